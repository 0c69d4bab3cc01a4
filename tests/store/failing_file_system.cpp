#include "tests/store/failing_file_system.h"

namespace phiz::test {

namespace fs = std::filesystem;

void FailingFileSystem::step(Effect effect) {
  const std::uint64_t call = ++calls_;
  if (call < fail_at_) return;
  switch (failure_) {
    case Failure::kOnce:
      if (call == fail_at_) throw StoreError(StoreFault::kIo, "the disk failed once, as the test asked");
      return;
    case Failure::kFull:
      if (effect == Effect::kWrites)
        throw StoreError(StoreFault::kFull, "the disk is full, as the test asked");
      return;
    case Failure::kStopped:
      throw StoreError(StoreFault::kIo, "the disk is gone, as the test asked");
  }
}

std::optional<FileSystem::Status> FailingFileSystem::find_status(const fs::path& path) {
  step(Effect::kReads);
  return disk_.find_status(path);
}

void FailingFileSystem::read_blocks(const fs::path& path, const TakeBlock& take) {
  step(Effect::kReads);
  disk_.read_blocks(path, take);
}

std::vector<std::string> FailingFileSystem::list_folder(const fs::path& path) {
  step(Effect::kReads);
  return disk_.list_folder(path);
}

bool FailingFileSystem::make_folder(const fs::path& path) {
  step(Effect::kWrites);
  return disk_.make_folder(path);
}

void FailingFileSystem::create_file(const fs::path& path, std::span<const std::byte> bytes, Mode mode) {
  try {
    step(Effect::kWrites);
  } catch (const StoreError&) {
    const bool is_first_failure = calls_ == fail_at_;
    if (is_first_failure) disk_.create_file(path, bytes.first(bytes.size() / 2), mode);  // as a real disk may
    throw;
  }
  disk_.create_file(path, bytes, mode);
}

void FailingFileSystem::append(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  step(Effect::kWrites);
  disk_.append(path, bytes);
}

void FailingFileSystem::sync_file(const fs::path& path) {
  step(Effect::kWrites);
  disk_.sync_file(path);
}

void FailingFileSystem::sync_folder(const fs::path& path) {
  step(Effect::kWrites);
  disk_.sync_folder(path);
}

void FailingFileSystem::rename(const fs::path& from, const fs::path& to) {
  step(Effect::kWrites);
  disk_.rename(from, to);
}

bool FailingFileSystem::create_exclusively(const fs::path& path, std::span<const std::byte> bytes) {
  step(Effect::kWrites);
  return disk_.create_exclusively(path, bytes);
}

bool FailingFileSystem::remove_file(const fs::path& path) {
  step(Effect::kRemoves);
  return disk_.remove_file(path);
}

bool FailingFileSystem::remove_folder(const fs::path& path) {
  step(Effect::kRemoves);
  return disk_.remove_folder(path);
}

}  // namespace phiz::test
