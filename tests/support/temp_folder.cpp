#include "tests/support/temp_folder.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cstdio>
#include <stdexcept>
#include <string>
#include <system_error>

namespace phiz::test {

TempFolder::TempFolder() {
  std::string name = "phiz";
  if (const auto* info = testing::UnitTest::GetInstance()->current_test_info())
    name += std::string("-") + info->test_suite_name() + "." + info->name();
  for (char& c : name)
    if (c == '/') c = '_';
  std::string pattern = (std::filesystem::temp_directory_path() / (name + "-XXXXXX")).string();
  if (!mkdtemp(pattern.data())) throw std::runtime_error("cannot make a temp folder: " + pattern);
  path_ = pattern;
}

TempFolder::~TempFolder() {
  if (testing::Test::HasFailure()) {
    std::fprintf(stderr, "kept: %s\n", path_.c_str());
    return;
  }
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace phiz::test
