#pragma once

#include "store/file_system.h"

namespace phiz::bench {

/// The real disk without the syncs: to make large stores that nobody needs after a power cut.
class QuickDisk final : public FileSystem {
 public:
  std::optional<Status> find_status(const std::filesystem::path& path) override {
    return disk_.find_status(path);
  }
  std::string find_stamp(const std::filesystem::path& path) override { return disk_.find_stamp(path); }
  void read_blocks(const std::filesystem::path& path, const TakeBlock& take) override {
    disk_.read_blocks(path, take);
  }
  std::vector<std::string> list_folder(const std::filesystem::path& path) override {
    return disk_.list_folder(path);
  }
  bool make_folder(const std::filesystem::path& path) override { return disk_.make_folder(path); }
  void create_file(const std::filesystem::path& path, std::span<const std::byte> bytes, Mode mode) override {
    disk_.create_file(path, bytes, mode);
  }
  void append(const std::filesystem::path& path, std::span<const std::byte> bytes) override {
    disk_.append(path, bytes);
  }
  void sync_file(const std::filesystem::path&) override {}
  void sync_folder(const std::filesystem::path&) override {}
  void rename(const std::filesystem::path& from, const std::filesystem::path& to) override {
    disk_.rename(from, to);
  }
  bool create_exclusively(const std::filesystem::path& path, std::span<const std::byte> bytes) override {
    return disk_.create_exclusively(path, bytes);
  }
  bool remove_file(const std::filesystem::path& path) override { return disk_.remove_file(path); }
  bool remove_folder(const std::filesystem::path& path) override { return disk_.remove_folder(path); }

 private:
  FileSystem& disk_ = real_file_system();
};

}  // namespace phiz::bench
