#include "tests/lint/sizes.h"

#include <gtest/gtest.h>

namespace phiz::lint {
namespace {

std::string repeat(const std::string& line, int count) {
  std::string text;
  for (int i = 0; i < count; ++i) text += line;
  return text;
}

int count_in(const std::string& path, const std::string& text) {
  return static_cast<int>(find_size_violations({make_source(path, text)}).size());
}

TEST(Sizes, TheTreeKeepsTheLimits) {
  const auto files =
      read_source_tree({"formats", "store", "stages", "orchestrator", "tests"}, {".h", ".cpp"});
  ASSERT_GT(files.size(), 50u) << "the tree was not found";
  for (const std::string& violation : find_size_violations(files)) ADD_FAILURE() << violation;
}

TEST(Sizes, PlantedViolationsAreCaught) {
  EXPECT_EQ(count_in("a.h", "#pragma once\n" + repeat("// x\n", 150)), 1);
  EXPECT_EQ(count_in("a.h", "int x;\n"), 1) << "no pragma";
  EXPECT_EQ(count_in("a.cpp", repeat("// x\n", 401)), 1);
  EXPECT_EQ(count_in("a.cpp", "void f() {\n" + repeat("  x();\n", 59) + "}\n"), 1);
  EXPECT_EQ(count_in("a.cpp", "void f(int a,\n       int b) {\n" + repeat("  x();\n", 58) + "}\n"), 1);
  EXPECT_EQ(count_in("a.cpp", "class A {\n  void f() {\n" + repeat("    x();\n", 60) + "  }\n};\n"), 1);
}

TEST(Sizes, WhatIsWithinTheLimitsIsNotCaught) {
  EXPECT_EQ(count_in("a.h", "#pragma once\n" + repeat("// x\n", 149)), 0);
  EXPECT_EQ(count_in("a.cpp", repeat("// x\n", 400)), 0);
  EXPECT_EQ(count_in("a.cpp", "void f() {\n" + repeat("  x();\n", 58) + "}\n"), 0);
  EXPECT_EQ(count_in("a.cpp", "class A {\n" + repeat("  void f() { x(); }\n", 100) + "};\n"), 0);
  EXPECT_EQ(count_in("a.cpp", "constexpr int kTable[] = {\n" + repeat("    1,\n", 100) + "};\n"), 0);
  EXPECT_EQ(count_in("a.cpp", "void f() {\n  const auto x = {\n      1, 2};\n}\n" + repeat("// x\n", 80)), 0);
  EXPECT_EQ(count_in("tests/a.cpp", "void f() {\n" + repeat("  x();\n", 100) + "}\n"), 0);
  EXPECT_EQ(count_in("a.cpp", repeat("void f() {\n  x();\n}\n\n", 50)), 0);
}

}  // namespace
}  // namespace phiz::lint
