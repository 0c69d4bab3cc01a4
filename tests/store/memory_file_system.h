#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "store/file_system.h"

namespace phiz::test {

/// A disk in memory that keeps apart what was done and what would survive a power cut: bytes only after
/// sync_file, names only after sync_folder of their folder.
class MemoryFileSystem final : public FileSystem {
 public:
  MemoryFileSystem();

  /// The disk as it may look after a power cut now. Each unsynced file keeps nothing, a part or all of its
  /// bytes; each name that changed since the last sync of its folder is old or new, one by one, so that
  /// renames may be reordered. `seed` chooses.
  std::unique_ptr<MemoryFileSystem> after_power_cut(std::uint64_t seed) const;

  /// Flips one bit in place, past every door. `bit` counts from the file's first byte.
  void flip_bit(const std::filesystem::path& path, std::uint64_t bit);

  /// Every file there is, sorted.
  std::vector<std::filesystem::path> list_all_files() const;

  /// Bytes that may still be created; kFull beyond.
  void set_free_bytes(std::uint64_t bytes) { free_bytes_ = bytes; }

  /// Files made or renamed from now on are so much younger.
  void advance_clock(double seconds) { clock_seconds_ += seconds; }

  std::uint64_t files_created() const { return files_created_; }

  std::optional<Status> find_status(const std::filesystem::path& path) override;
  void read_blocks(const std::filesystem::path& path, const TakeBlock& take) override;
  std::vector<std::string> list_folder(const std::filesystem::path& path) override;
  bool make_folder(const std::filesystem::path& path) override;
  void create_file(const std::filesystem::path& path, std::span<const std::byte> bytes, Mode mode) override;
  void append(const std::filesystem::path& path, std::span<const std::byte> bytes) override;
  void sync_file(const std::filesystem::path& path) override;
  void sync_folder(const std::filesystem::path& path) override;
  void rename(const std::filesystem::path& from, const std::filesystem::path& to) override;
  bool create_exclusively(const std::filesystem::path& path, std::span<const std::byte> bytes) override;
  bool remove_file(const std::filesystem::path& path) override;
  bool remove_folder(const std::filesystem::path& path) override;
  std::optional<double> find_change_time_seconds(const std::filesystem::path& path) override;

 private:
  struct File {
    std::string bytes;
    bool is_synced = false;
    double change_time_seconds = 0;
  };
  struct Entry {
    std::shared_ptr<File> file;  // null: a folder
    bool operator==(const Entry&) const = default;
  };
  using Names = std::map<std::string, Entry>;
  struct Folder {
    Names names, durable_names;
  };

  Folder& folder_of(const std::filesystem::path& path);
  Entry* find_entry(const std::filesystem::path& path);
  void create(const std::filesystem::path& path, std::span<const std::byte> bytes);

  mutable std::recursive_mutex mutex_;
  std::map<std::filesystem::path, Folder> folders_;
  std::uint64_t free_bytes_ = UINT64_MAX;
  std::uint64_t files_created_ = 0;
  double clock_seconds_ = 0;
};

}  // namespace phiz::test
