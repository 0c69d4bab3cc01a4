#include "store/file_system.h"

#include "store/error.h"

namespace phiz {

std::string FileSystem::read_file(const std::filesystem::path& path, std::uint64_t max_bytes) {
  std::string bytes;
  if (const auto status = find_status(path)) {
    if (status->size_bytes <= max_bytes) bytes.reserve(status->size_bytes);
  }
  read_blocks(path, [&](std::span<const std::byte> block) {
    if (block.size() > max_bytes - bytes.size()) {
      throw StoreError(StoreFault::kIo,
                       path.string() + ": longer than the " + std::to_string(max_bytes) + " bytes allowed");
    }
    bytes.append(reinterpret_cast<const char*>(block.data()), block.size());
  });
  return bytes;
}

void FileSystem::make_folders(const std::filesystem::path& path) {
  if (path.empty()) return;
  const auto status = find_status(path);
  if (status && status->kind == Kind::kFolder) return;
  const std::filesystem::path parent = path.parent_path();
  if (parent != path) make_folders(parent);
  try {
    make_folder(path);
  } catch (const StoreError& error) {
    // Its parent is there, so this is no place for folders: /proc, or a file of that name.
    if (error.fault() != StoreFault::kMissing && error.fault() != StoreFault::kExists) throw;
    throw StoreError(StoreFault::kPermission, error.what(), "name a folder that can be made");
  }
  sync_folder(parent.empty() ? std::filesystem::path(".") : parent);
}

}  // namespace phiz
