#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

namespace phiz::readers {

/// The bytes of a whole file, read once.
struct FileBytes {
  std::unique_ptr<std::byte[]> data;
  std::size_t size = 0;
  std::span<const std::byte> view() const { return {data.get(), size}; }
};

/// Reads a regular file or a pipe. Throws FormatError naming the cause: not there, a directory, no
/// permission, empty, a device, out of memory. Not mapped: a file that shrinks meanwhile is an error, not a
/// crash.
FileBytes read_file_bytes(const std::filesystem::path& path);

}  // namespace phiz::readers
