#include "tests/store/memory_file_system.h"

#include <algorithm>

#include "store/error.h"
#include "tests/support/random.h"

namespace phiz::test {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void fail(StoreFault fault, const char* what, const fs::path& path) {
  throw StoreError(fault, std::string(what) + " " + path.string());
}

}  // namespace

MemoryFileSystem::MemoryFileSystem() {
  folders_["/"];
}

MemoryFileSystem::Folder& MemoryFileSystem::folder_of(const fs::path& path) {
  const auto found = folders_.find(path.parent_path());
  if (found == folders_.end()) fail(StoreFault::kMissing, "no folder for", path);
  return found->second;
}

MemoryFileSystem::Entry* MemoryFileSystem::find_entry(const fs::path& path) {
  const auto folder = folders_.find(path.parent_path());
  if (folder == folders_.end()) return nullptr;
  const auto entry = folder->second.names.find(path.filename().string());
  return entry == folder->second.names.end() ? nullptr : &entry->second;
}

std::unique_ptr<MemoryFileSystem> MemoryFileSystem::after_power_cut(std::uint64_t seed) const {
  const std::lock_guard lock(mutex_);
  Random choose(seed);
  auto after = std::make_unique<MemoryFileSystem>();
  std::map<const File*, std::shared_ptr<File>> copies;
  const auto survive = [&](const Entry& entry) {
    if (!entry.file) return Entry{};
    std::shared_ptr<File>& copy = copies[entry.file.get()];
    if (!copy) {
      copy = std::make_shared<File>(*entry.file);
      if (!copy->is_synced) copy->bytes.resize(choose.below(copy->bytes.size() + 1));
      copy->is_synced = true;
    }
    return Entry{copy};
  };
  for (const auto& [path, folder] : folders_) {
    const bool is_reachable =
        path == "/" || (after->folders_.contains(path.parent_path()) &&
                        after->folders_[path.parent_path()].names.contains(path.filename().string()));
    if (!is_reachable) continue;
    Names names = folder.durable_names;
    for (const auto& [name, entry] : folder.names) {
      const auto before = folder.durable_names.find(name);
      const bool changed = before == folder.durable_names.end() || !(before->second == entry);
      if (changed && choose.below(2) == 1) names[name] = entry;
    }
    for (const auto& [name, entry] : folder.durable_names) {
      if (!folder.names.contains(name) && choose.below(2) == 1) names.erase(name);
    }
    Folder& kept = after->folders_[path];
    for (const auto& [name, entry] : names) {
      kept.names[name] = survive(entry);
      if (!entry.file) after->folders_[path / name];
    }
    kept.durable_names = kept.names;
  }
  return after;
}

void MemoryFileSystem::flip_bit(const fs::path& path, std::uint64_t bit) {
  const std::lock_guard lock(mutex_);
  find_entry(path)->file->bytes.at(bit / 8) ^= static_cast<char>(1 << (bit % 8));
}

std::vector<fs::path> MemoryFileSystem::list_all_files() const {
  const std::lock_guard lock(mutex_);
  std::vector<fs::path> paths;
  for (const auto& [path, folder] : folders_) {
    for (const auto& [name, entry] : folder.names) {
      if (entry.file) paths.push_back(path / name);
    }
  }
  return paths;
}

std::optional<FileSystem::Status> MemoryFileSystem::find_status(const fs::path& path) {
  const std::lock_guard lock(mutex_);
  if (folders_.contains(path)) return Status{Kind::kFolder, 0};
  const Entry* entry = find_entry(path);
  if (entry == nullptr) return std::nullopt;
  return Status{Kind::kFile, entry->file->bytes.size()};
}

void MemoryFileSystem::read_blocks(const fs::path& path, const TakeBlock& take) {
  std::shared_ptr<File> file;
  {
    const std::lock_guard lock(mutex_);
    const Entry* entry = find_entry(path);
    if (entry == nullptr) fail(StoreFault::kMissing, "no file", path);
    if (!entry->file) fail(StoreFault::kIo, "a folder", path);
    file = entry->file;
  }
  constexpr std::size_t kBlockBytes = 7;  // small, so that readers meet many blocks
  const auto bytes = std::as_bytes(std::span(file->bytes));
  for (std::size_t begin = 0; begin < bytes.size(); begin += kBlockBytes) {
    take(bytes.subspan(begin, std::min(kBlockBytes, bytes.size() - begin)));
  }
}

std::vector<std::string> MemoryFileSystem::list_folder(const fs::path& path) {
  const std::lock_guard lock(mutex_);
  const auto folder = folders_.find(path);
  if (folder == folders_.end()) fail(StoreFault::kMissing, "no folder", path);
  std::vector<std::string> names;
  for (const auto& [name, entry] : folder->second.names) names.push_back(name);
  return names;
}

bool MemoryFileSystem::make_folder(const fs::path& path) {
  const std::lock_guard lock(mutex_);
  if (folders_.contains(path)) return false;
  if (find_entry(path) != nullptr) fail(StoreFault::kExists, "a file is there:", path);
  folder_of(path).names[path.filename().string()] = Entry{};
  folders_[path];
  return true;
}

void MemoryFileSystem::create(const fs::path& path, std::span<const std::byte> bytes) {
  Folder& folder = folder_of(path);
  if (find_entry(path) != nullptr) fail(StoreFault::kExists, "there is", path);
  if (bytes.size() > free_bytes_) fail(StoreFault::kFull, "no space left for", path);
  if (free_bytes_ != UINT64_MAX) free_bytes_ -= bytes.size();
  auto file = std::make_shared<File>();
  file->bytes.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  file->change_time_seconds = clock_seconds_;
  folder.names[path.filename().string()] = Entry{file};
  ++files_created_;
}

void MemoryFileSystem::create_file(const fs::path& path, std::span<const std::byte> bytes, Mode) {
  const std::lock_guard lock(mutex_);
  create(path, bytes);
}

void MemoryFileSystem::append(const fs::path& path, std::span<const std::byte> bytes) {
  const std::lock_guard lock(mutex_);
  if (find_entry(path) == nullptr) create(path, {});
  File& file = *find_entry(path)->file;
  if (bytes.size() > free_bytes_) fail(StoreFault::kFull, "no space left for", path);
  file.bytes.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  file.is_synced = false;
}

void MemoryFileSystem::sync_file(const fs::path& path) {
  const std::lock_guard lock(mutex_);
  const Entry* entry = find_entry(path);
  if (entry == nullptr) fail(StoreFault::kMissing, "no file", path);
  entry->file->is_synced = true;
}

void MemoryFileSystem::sync_folder(const fs::path& path) {
  const std::lock_guard lock(mutex_);
  const auto folder = folders_.find(path);
  if (folder == folders_.end()) fail(StoreFault::kMissing, "no folder", path);
  folder->second.durable_names = folder->second.names;
}

void MemoryFileSystem::rename(const fs::path& from, const fs::path& to) {
  const std::lock_guard lock(mutex_);
  const Entry* entry = find_entry(from);
  if (entry == nullptr) fail(StoreFault::kMissing, "no file", from);
  const Entry moved = *entry;
  if (moved.file) moved.file->change_time_seconds = clock_seconds_;
  folder_of(to).names[to.filename().string()] = moved;
  folder_of(from).names.erase(from.filename().string());
}

bool MemoryFileSystem::create_exclusively(const fs::path& path, std::span<const std::byte> bytes) {
  const std::lock_guard lock(mutex_);
  if (find_entry(path) != nullptr) return false;
  create(path, bytes);
  return true;
}

bool MemoryFileSystem::remove_file(const fs::path& path) {
  const std::lock_guard lock(mutex_);
  if (find_entry(path) == nullptr) return false;
  folder_of(path).names.erase(path.filename().string());
  return true;
}

std::optional<double> MemoryFileSystem::find_change_time_seconds(const fs::path& path) {
  const std::lock_guard lock(mutex_);
  const Entry* entry = find_entry(path);
  if (entry == nullptr || !entry->file) return std::nullopt;
  return entry->file->change_time_seconds;
}

bool MemoryFileSystem::remove_folder(const fs::path& path) {
  const std::lock_guard lock(mutex_);
  const auto folder = folders_.find(path);
  if (folder == folders_.end() || !folder->second.names.empty()) return false;
  folders_.erase(folder);
  folder_of(path).names.erase(path.filename().string());
  return true;
}

}  // namespace phiz::test
