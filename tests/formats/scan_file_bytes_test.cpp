#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "formats/error.h"
#include "formats/readers/file_bytes.h"
#include "tests/support/temp_folder.h"

namespace phiz::readers {
namespace {

std::string fault_of(const std::filesystem::path& path) {
  try {
    read_file_bytes(path);
  } catch (const FormatError& error) {
    return error.what();
  }
  return {};
}

TEST(ScanFileBytes, NamesTheCause) {
  const test::TempFolder folder;
  std::ofstream(folder / "empty.ply");
  std::ofstream(folder / "secret.ply") << "ply";
  std::filesystem::permissions(folder / "secret.ply", std::filesystem::perms::none);
  EXPECT_EQ(fault_of(folder / "nothing.ply"), "no such file");
  EXPECT_EQ(fault_of(folder / "empty.ply" / "x"), "no such file");
  EXPECT_EQ(fault_of(folder.path()), "is a directory, not a scan");
  EXPECT_EQ(fault_of(folder / "empty.ply"), "is empty (byte 0)");
  EXPECT_EQ(fault_of("/dev/zero"), "is a device, not a scan");
  if (::geteuid() != 0) {
    EXPECT_EQ(fault_of(folder / "secret.ply"), "no permission to read");
  }
}

TEST(ScanFileBytes, GivesTheBytesOfTheFile) {
  const test::TempFolder folder;
  const std::string text = "a scan\0of bytes\n";
  std::ofstream(folder / "a.bin", std::ios::binary) << text;
  const FileBytes bytes = read_file_bytes(folder / "a.bin");
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(bytes.data.get()), bytes.size), text);
}

}  // namespace
}  // namespace phiz::readers
