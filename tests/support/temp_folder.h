#pragma once

#include <filesystem>
#include <string_view>

namespace phiz::test {

/// A new empty folder for the running test, removed with everything in it at the end of its scope.
/// If the test has failed by then the folder is kept and its path printed.
class TempFolder {
 public:
  TempFolder();
  ~TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(std::string_view name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace phiz::test
