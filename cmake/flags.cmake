# Flags live on one interface target that product and tests link privately.
# -ffp-contract=off: the same bits whether or not the machine has FMA.
add_library(phiz_flags INTERFACE)
target_compile_features(phiz_flags INTERFACE cxx_std_20)
target_compile_options(phiz_flags INTERFACE -Wall -Wextra -Wshadow -Wpedantic -ffp-contract=off)
if(PHIZ_WARNINGS_AS_ERRORS)
  target_compile_options(phiz_flags INTERFACE -Werror)
endif()
# One include root: "formats/point_cloud.h", "stages/fit/fit.h". The lint test holds the layers.
target_include_directories(phiz_flags INTERFACE ${PROJECT_SOURCE_DIR})

# phiz_library(NAME SOURCES... LINK public libs... PRIVATE private libs...)
function(phiz_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK;PRIVATE" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC Eigen3::Eigen ${ARG_LINK} PRIVATE phiz_flags ${ARG_PRIVATE})
endfunction()
