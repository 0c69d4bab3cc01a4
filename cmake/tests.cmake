find_package(GTest CONFIG REQUIRED)
include(GoogleTest)

# phiz_test(NAME LABEL fast|slow|e2e|crash|fuzz|lint SOURCES... LINK libs...)
# One executable per folder and cost; each GoogleTest case becomes one CTest case with one label.
function(phiz_test name)
  cmake_parse_arguments(ARG "" "LABEL" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE phiz_flags phiz_test_support ${ARG_LINK})
  gtest_discover_tests(${name} TEST_PREFIX "${name}." PROPERTIES LABELS ${ARG_LABEL} DISCOVERY_TIMEOUT 120)
endfunction()
