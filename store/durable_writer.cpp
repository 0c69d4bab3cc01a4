#include "store/durable_writer.h"

#include <unistd.h>

#include <atomic>
#include <random>

#include "store/error.h"

namespace phiz {

namespace {
constexpr char kTemporaryPrefix[] = ".tmp-";
}

DurableWriter::~DurableWriter() {
  for (const Pending& file : pending_) {
    try {
      files_.remove_file(file.temporary);
    } catch (const StoreError&) {
      // A temporary file that stays is never read.
    }
  }
}

void DurableWriter::add(const std::filesystem::path& target, std::span<const std::byte> bytes,
                        FileSystem::Mode mode) {
  const std::filesystem::path temporary = target.parent_path() / (kTemporaryPrefix + make_unique_name());
  pending_.push_back({temporary, target});
  files_.create_file(temporary, bytes, mode);
  folders_.insert(target.parent_path());
}

void DurableWriter::make_folder(const std::filesystem::path& folder) {
  if (files_.make_folder(folder)) folders_.insert(folder.parent_path());
}

void DurableWriter::publish() {
  for (const Pending& file : pending_) files_.sync_file(file.temporary);
  while (!pending_.empty()) {
    files_.rename(pending_.front().temporary, pending_.front().target);
    pending_.erase(pending_.begin());
  }
  for (const std::filesystem::path& folder : folders_) files_.sync_folder(folder);
  folders_.clear();
}

bool is_temporary_name(const std::string& name) {
  return name.starts_with(kTemporaryPrefix);
}

std::string make_unique_name() {
  static const std::uint64_t process_part =
      (std::uint64_t{std::random_device{}()} << 32) | std::random_device{}();
  static std::atomic<std::uint64_t> counter{0};
  return std::to_string(process_part ^ static_cast<std::uint64_t>(::getpid())) + "-" +
         std::to_string(counter++);
}

}  // namespace phiz
