#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace phiz {

/// The one door to the operating system's files. Everything phiz reads or writes on disk goes through here,
/// so that tests can put an in-memory disk behind it, let the n-th operation fail, or cut the power.
///
/// Every call throws StoreError with a fitting fault (kMissing, kExists, kFull, kPermission, kIo) and the
/// path in its text. Calls may come from any thread. No call relies on flock, mmap or modification times.
class FileSystem {
 public:
  enum class Kind { kFile, kFolder, kOther };
  struct Status {
    Kind kind = Kind::kOther;
    std::uint64_t size_bytes = 0;
  };
  enum class Mode { kWritable, kReadOnly };

  virtual ~FileSystem() = default;

  /// What is at `path` (a symbolic link is followed); nothing if there is nothing. Other failures throw.
  virtual std::optional<Status> find_status(const std::filesystem::path& path) = 0;

  /// Calls `take` with consecutive blocks of the file. The whole file is never held. Throws kMissing; kIo for
  /// a folder.
  using TakeBlock = std::function<void(std::span<const std::byte> block)>;
  virtual void read_blocks(const std::filesystem::path& path, const TakeBlock& take) = 0;

  /// Names in a folder, sorted bytewise.
  virtual std::vector<std::string> list_folder(const std::filesystem::path& path) = 0;

  /// One level; true if it was made, false if the folder was there.
  virtual bool make_folder(const std::filesystem::path& path) = 0;

  /// Makes a new file with these bytes; kExists if the name is taken. Not durable before sync_file and
  /// sync_folder.
  virtual void create_file(const std::filesystem::path& path, std::span<const std::byte> bytes,
                           Mode mode) = 0;

  /// After this the file's bytes (not its name) survive a power cut.
  virtual void sync_file(const std::filesystem::path& path) = 0;

  /// After this the names in the folder, as they are now, survive a power cut.
  virtual void sync_folder(const std::filesystem::path& path) = 0;

  /// Atomic; replaces `to` if it is a file. Both must lie on one file system.
  virtual void rename(const std::filesystem::path& from, const std::filesystem::path& to) = 0;

  /// Makes a file that must be the first of its name, whole or not at all; false if the name is taken.
  /// Exclusive between processes and machines (link(2), NFS included). Not durable.
  virtual bool create_exclusively(const std::filesystem::path& path, std::span<const std::byte> bytes) = 0;

  /// True if it was there. Removes a file (never a folder).
  virtual bool remove_file(const std::filesystem::path& path) = 0;

  /// Removes an empty folder; true if it was there and is gone, false if it was not there or is not empty.
  virtual bool remove_folder(const std::filesystem::path& path) = 0;

  /// A text that is another one as soon as the file is another or was written to: device, number, length and
  /// times. Empty where that cannot be relied upon (a disk without such times, a file changed a moment ago).
  /// Only for files that are not ours: nothing in the store is judged by its times.
  virtual std::string find_stamp(const std::filesystem::path&) { return {}; }

  /// Adds bytes at the end of a file, which is made if it is not there. Whole unless the machine fails; not
  /// durable. For logs.
  virtual void append(const std::filesystem::path& path, std::span<const std::byte> bytes) = 0;

  /// When the file was last written, renamed or linked, by the clock of the disk it lies on; nothing if there
  /// is none or the disk does not tell. Only to be compared with another file's of the same disk.
  virtual std::optional<double> find_change_time_seconds(const std::filesystem::path&) { return {}; }

  /// The whole file. Throws kMissing; kIo for a folder and if it is longer than max_bytes.
  virtual std::string read_file(const std::filesystem::path& path, std::uint64_t max_bytes = UINT64_MAX);

  /// make_folder for `path` and every missing parent, each made durable.
  void make_folders(const std::filesystem::path& path);
};

/// The real disk. One object for the process.
FileSystem& real_file_system();

}  // namespace phiz
