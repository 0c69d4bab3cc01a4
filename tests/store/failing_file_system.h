#pragma once

#include <atomic>
#include <cstdint>
#include <limits>

#include "store/error.h"
#include "store/file_system.h"

namespace phiz::test {

/// A disk that fails at the n-th call (counted from 1 over every operation), in one of three ways.
class FailingFileSystem final : public FileSystem {
 public:
  enum class Failure {
    kOnce,     ///< this call fails with kIo, later ones work
    kFull,     ///< from here on nothing can be written (kFull); reading and removing work
    kStopped,  ///< this and every later call fails: the process is dead to the disk
  };
  static constexpr std::uint64_t kNever = std::numeric_limits<std::uint64_t>::max();

  FailingFileSystem(FileSystem& disk, std::uint64_t fail_at, Failure failure)
      : disk_(disk), fail_at_(fail_at), failure_(failure) {}

  std::uint64_t calls() const { return calls_; }
  bool has_failed() const { return calls_ >= fail_at_; }

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
  std::optional<double> find_change_time_seconds(const std::filesystem::path& path) override {
    return disk_.find_change_time_seconds(path);
  }

 private:
  enum class Effect { kReads, kWrites, kRemoves };
  void step(Effect effect);

  FileSystem& disk_;
  std::uint64_t fail_at_;
  Failure failure_;
  std::atomic<std::uint64_t> calls_ = 0;
};

}  // namespace phiz::test
