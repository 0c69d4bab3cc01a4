#pragma once

#include <gtest/gtest.h>

#include <filesystem>

namespace phiz::test {

/// The folder of test scans: $PHIZ_DATA, by default `../shared/data` beside the source tree. Empty if it is
/// not there.
std::filesystem::path phiz_data_folder();

}  // namespace phiz::test

/// First line of a test that needs the scans: skips it, saying why, where there are none.
#define PHIZ_SKIP_WITHOUT_DATA()                \
  if (::phiz::test::phiz_data_folder().empty()) \
  GTEST_SKIP() << "no test scans: set PHIZ_DATA to a folder with subjects.json"
