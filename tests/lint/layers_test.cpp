#include "tests/lint/layers.h"

#include <gtest/gtest.h>

namespace phiz::lint {
namespace {

int count_in(const std::string& path, const std::string& text) {
  return static_cast<int>(find_layer_violations({make_source(path, text)}).size());
}

TEST(Layers, TheTreeHoldsThem) {
  const auto files =
      read_source_tree({"formats", "store", "stages", "orchestrator", "tests"}, {".h", ".cpp", ".inl"});
  ASSERT_GT(files.size(), 50u) << "the tree was not found";
  for (const std::string& violation : find_layer_violations(files)) ADD_FAILURE() << violation;
}

TEST(Layers, PlantedViolationsAreCaught) {
  EXPECT_EQ(count_in("formats/a.cpp", "#include \"store/store.h\"\n"), 1);
  EXPECT_EQ(count_in("formats/a.cpp", "#include \"stages/geometry/error.h\"\n"), 1);
  EXPECT_EQ(count_in("store/a.cpp", "#  include \"formats/error.h\"\n"), 1);
  EXPECT_EQ(count_in("stages/fit/a.cpp", "#include \"store/store.h\"\n"), 1);
  EXPECT_EQ(count_in("stages/fit/a.cpp", "#include \"orchestrator/run.h\"\n"), 1);
  EXPECT_EQ(count_in("stages/fit/a.cpp", "#include \"stages/align/silhouette.h\"\n"), 1);
  EXPECT_EQ(count_in("stages/geometry/a.cpp", "#include \"stages/fit/fit.h\"\n"), 1);
  EXPECT_EQ(count_in("orchestrator/a.cpp", "#include \"tests/support/random.h\"\n"), 1);
  EXPECT_EQ(count_in("store/a.cpp", "#include \"digest.h\"\n"), 1);
  EXPECT_EQ(count_in("formats/a.h", "#include <openvdb/openvdb.h>\n"), 1);
  EXPECT_EQ(count_in("stages/fit/a.h", "#include <nanoflann.hpp>\n"), 1);
}

TEST(Layers, WhatIsAllowedIsNotCaught) {
  EXPECT_EQ(count_in("formats/a.cpp", "#include <openvdb/openvdb.h>\n#include \"formats/error.h\"\n"), 0);
  EXPECT_EQ(
      count_in("stages/fit/a.cpp", "#include \"stages/geometry/normals.h\"\n#include \"formats/image.h\"\n"),
      0);
  EXPECT_EQ(count_in("stages/fit/a.cpp", "#include \"stages/subdivide/subdivide.h\"\n"), 0);
  EXPECT_EQ(count_in("orchestrator/a.cpp", "#include \"store/store.h\"\n#include \"stages/fit/fit.h\"\n"), 0);
  EXPECT_EQ(count_in("store/a.cpp", "// #include \"formats/error.h\"\n"), 0);
}

TEST(Layers, ACircleOfStagesIsCaught) {
  const auto circle = find_layer_violations({make_source("stages/a/a.h", "#include \"stages/b/b.h\"\n"),
                                             make_source("stages/b/b.cpp", "#include \"stages/c/c.h\"\n"),
                                             make_source("stages/c/c.h", "#include \"stages/a/a.h\"\n")});
  EXPECT_EQ(circle.size(), 1u);
}

}  // namespace
}  // namespace phiz::lint
