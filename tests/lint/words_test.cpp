// Words and flags that must not stand in the tree.

#include <gtest/gtest.h>

#include "tests/lint/source_tree.h"

namespace phiz::lint {
namespace {

/// Lines with one of the words, as "path:line: word".
std::vector<std::string> find_words(const std::vector<SourceFile>& files,
                                    const std::vector<std::string>& words) {
  std::vector<std::string> found;
  for (const SourceFile& file : files) {
    for (std::size_t i = 0; i < file.lines.size(); ++i) {
      for (const std::string& word : words) {
        if (file.lines[i].find(word) == std::string::npos) continue;
        found.push_back(file.path + ":" + std::to_string(i + 1) + ": " + word);
      }
    }
  }
  return found;
}

// Written in pieces, so that this file does not hold them.
const std::vector<std::string> kUnfinished = {std::string("TO") + "DO", std::string("FIX") + "ME"};
const std::vector<std::string> kFlags = {std::string("-march=") + "native", std::string("-ffast-") + "math",
                                         std::string("GLOB") + " ", std::string("GLOB_") + "RECURSE"};
const std::vector<std::string> kFolders = {"formats", "store",   "stages", "orchestrator",
                                           "tests",   "samples", "cmake"};

TEST(Words, NothingIsLeftUnfinished) {
  for (const auto& place : find_words(
           read_source_tree(kFolders, {".h", ".cpp", ".inl", ".txt", ".cmake", ".sh", ".md"}), kUnfinished)) {
    ADD_FAILURE() << place;
  }
}

TEST(Words, NoBuildFileUsesForbiddenFlags) {
  for (const auto& place : find_words(read_source_tree(kFolders, {"CMakeLists.txt", ".cmake"}), kFlags)) {
    ADD_FAILURE() << place;
  }
}

TEST(Words, PlantedViolationsAreCaught) {
  EXPECT_EQ(find_words({make_source("a.cpp", "// " + kUnfinished[0] + ": later\n")}, kUnfinished).size(), 1u);
  EXPECT_EQ(find_words({make_source("CMakeLists.txt", "file(" + kFlags[2] + "x *.cpp)\n")}, kFlags).size(),
            1u);
  EXPECT_EQ(
      find_words({make_source("CMakeLists.txt", "add_compile_options(" + kFlags[0] + ")\n")}, kFlags).size(),
      1u);
}

}  // namespace
}  // namespace phiz::lint
