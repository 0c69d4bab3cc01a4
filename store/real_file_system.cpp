#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "store/durable_writer.h"
#include "store/error.h"
#include "store/file_system.h"

namespace phiz {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBlockBytes = 1 << 18;
constexpr std::int64_t kClockGrainNs = 100'000'000;

[[noreturn]] void throw_errno(const char* action, const fs::path& path, int error) {
  StoreFault fault = StoreFault::kIo;
  std::string hint;
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      fault = StoreFault::kMissing;
      break;
    case EEXIST:
      fault = StoreFault::kExists;
      break;
    case ENOSPC:
    case EDQUOT:
      fault = StoreFault::kFull;
      hint = "free some space and run the same command to continue";
      break;
    case EACCES:
    case EPERM:
    case EROFS:
      fault = StoreFault::kPermission;
      break;
    default:
      break;
  }
  throw StoreError(fault, std::string(action) + " " + path.string() + ": " + std::strerror(error), hint);
}

/// An open file; closed on the way out. close() reports what the destructor cannot.
class Descriptor {
 public:
  Descriptor(const fs::path& path, int flags, mode_t mode, const char* action) : path_(path) {
    do fd_ = ::open(path.c_str(), flags | O_CLOEXEC, mode);
    while (fd_ < 0 && errno == EINTR);
    if (fd_ < 0) throw_errno(action, path, errno);
  }
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int get() const { return fd_; }
  void close() {
    const int fd = std::exchange(fd_, -1);
    if (::close(fd) != 0 && errno != EINTR) throw_errno("cannot close", path_, errno);
  }
  void sync() {
    int result;
    do result = ::fsync(fd_);
    while (result != 0 && errno == EINTR);
    if (result != 0) throw_errno("cannot sync", path_, errno);
  }

 private:
  fs::path path_;
  int fd_ = -1;
};

void write_all(int fd, std::span<const std::byte> bytes, const fs::path& path) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), std::min<std::size_t>(bytes.size(), 1 << 30));
    if (written < 0) {
      if (errno == EINTR) continue;
      throw_errno("cannot write", path, errno);
    }
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

class RealFileSystem final : public FileSystem {
 public:
  std::optional<Status> find_status(const fs::path& path) override {
    struct stat info {};
    if (::stat(path.c_str(), &info) != 0) {
      if (errno == ENOENT || errno == ENOTDIR) return std::nullopt;
      throw_errno("cannot look at", path, errno);
    }
    Status status;
    status.kind = S_ISREG(info.st_mode) ? Kind::kFile : S_ISDIR(info.st_mode) ? Kind::kFolder : Kind::kOther;
    status.size_bytes = status.kind == Kind::kFile ? static_cast<std::uint64_t>(info.st_size) : 0;
    return status;
  }

  std::string find_stamp(const fs::path& path) override {
    // Opened first: on NFS that asks the server, where a bare stat may answer from memory.
    Descriptor file(path, O_RDONLY | O_NONBLOCK, 0, "cannot read");
    struct stat info {};
    timespec now{};
    if (::fstat(file.get(), &info) != 0 || ::clock_gettime(CLOCK_REALTIME, &now) != 0) return {};
    const auto to_ns = [](const timespec& time) {
      return static_cast<std::int64_t>(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
    };
    // A change within the clock's grain of the last one would not show.
    if (to_ns(now) - to_ns(info.st_ctim) < kClockGrainNs) return {};
    return std::to_string(info.st_dev) + ":" + std::to_string(info.st_ino) + ":" +
           std::to_string(info.st_size) + ":" + std::to_string(to_ns(info.st_mtim)) + ":" +
           std::to_string(to_ns(info.st_ctim));
  }

  std::optional<double> find_change_time_seconds(const fs::path& path) override {
    struct stat info {};
    if (::stat(path.c_str(), &info) != 0) return std::nullopt;
    return static_cast<double>(info.st_ctim.tv_sec) + 1e-9 * static_cast<double>(info.st_ctim.tv_nsec);
  }

  std::string read_file(const fs::path& path, std::uint64_t max_bytes) override {
    Descriptor file(path, O_RDONLY, 0, "cannot read");
    struct stat info {};
    if (::fstat(file.get(), &info) != 0) throw_errno("cannot look at", path, errno);
    const bool is_file = S_ISREG(info.st_mode) && info.st_size >= 0;
    // One byte more than there are, so that the end shows; what does not know its length grows as it is read.
    std::string bytes(is_file
                          ? std::min<std::uint64_t>(static_cast<std::uint64_t>(info.st_size), max_bytes) + 1
                          : kBlockBytes,
                      '\0');
    std::size_t used = 0;
    for (;;) {
      const ssize_t count = ::read(file.get(), bytes.data() + used, bytes.size() - used);
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) throw_errno("cannot read", path, errno);
      if (count == 0) break;
      used += static_cast<std::size_t>(count);
      if (used > max_bytes) {
        throw StoreError(StoreFault::kIo,
                         path.string() + ": longer than the " + std::to_string(max_bytes) + " bytes allowed");
      }
      if (used == bytes.size()) bytes.resize(2 * bytes.size());
    }
    bytes.resize(used);
    return bytes;
  }

  void read_blocks(const fs::path& path, const TakeBlock& take) override {
    Descriptor file(path, O_RDONLY, 0, "cannot read");
    struct stat info {};
    const bool is_small = ::fstat(file.get(), &info) == 0 && S_ISREG(info.st_mode) &&
                          info.st_size < static_cast<off_t>(kBlockBytes);
    std::vector<std::byte> block(is_small ? static_cast<std::size_t>(info.st_size) + 1 : kBlockBytes);
    for (;;) {
      const ssize_t count = ::read(file.get(), block.data(), block.size());
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) throw_errno("cannot read", path, errno);
      if (count == 0) return;
      take(std::span(block.data(), static_cast<std::size_t>(count)));
    }
  }

  std::vector<std::string> list_folder(const fs::path& path) override {
    DIR* folder = ::opendir(path.c_str());
    if (folder == nullptr) throw_errno("cannot list", path, errno);
    std::vector<std::string> names;
    errno = 0;
    while (const dirent* entry = ::readdir(folder)) {
      const std::string_view name = entry->d_name;
      if (name != "." && name != "..") names.emplace_back(name);
      errno = 0;
    }
    const int error = errno;
    ::closedir(folder);
    if (error != 0) throw_errno("cannot list", path, error);
    std::sort(names.begin(), names.end());
    return names;
  }

  bool make_folder(const fs::path& path) override {
    if (::mkdir(path.c_str(), 0777) == 0) return true;
    const int error = errno;
    if (error == EEXIST) {
      const auto status = find_status(path);
      if (status && status->kind == Kind::kFolder) return false;
    }
    throw_errno("cannot make folder", path, error);
  }

  void create_file(const fs::path& path, std::span<const std::byte> bytes, Mode mode) override {
    Descriptor file(path, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW, mode == Mode::kReadOnly ? 0444 : 0666,
                    "cannot create");
    try {
      write_all(file.get(), bytes, path);
      file.close();
    } catch (...) {
      ::unlink(path.c_str());
      throw;
    }
  }

  void append(const fs::path& path, std::span<const std::byte> bytes) override {
    Descriptor file(path, O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW, 0666, "cannot append to");
    write_all(file.get(), bytes, path);
    file.close();
  }

  void sync_file(const fs::path& path) override { Descriptor(path, O_RDONLY, 0, "cannot open").sync(); }

  void sync_folder(const fs::path& path) override {
    Descriptor(path, O_RDONLY | O_DIRECTORY, 0, "cannot open").sync();
  }

  void rename(const fs::path& from, const fs::path& to) override {
    if (::rename(from.c_str(), to.c_str()) != 0) throw_errno("cannot rename to", to, errno);
  }

  bool create_exclusively(const fs::path& path, std::span<const std::byte> bytes) override {
    const fs::path temporary = path.parent_path() / (".tmp-" + make_unique_name());
    create_file(temporary, bytes, Mode::kWritable);
    const int result = ::link(temporary.c_str(), path.c_str());
    const int error = errno;
    ::unlink(temporary.c_str());
    if (result == 0) return true;
    if (error == EEXIST) return false;
    if (error != EPERM && error != EOPNOTSUPP && error != ENOSYS && error != EMLINK) {
      throw_errno("cannot create", path, error);
    }
    try {  // a file system without hard links
      create_file(path, bytes, Mode::kWritable);
      return true;
    } catch (const StoreError& failure) {
      if (failure.fault() == StoreFault::kExists) return false;
      throw;
    }
  }

  bool remove_file(const fs::path& path) override {
    if (::unlink(path.c_str()) == 0) return true;
    if (errno == ENOENT || errno == ENOTDIR) return false;
    throw_errno("cannot remove", path, errno);
  }

  bool remove_folder(const fs::path& path) override {
    if (::rmdir(path.c_str()) == 0) return true;
    if (errno == ENOENT || errno == ENOTDIR || errno == ENOTEMPTY || errno == EEXIST) return false;
    throw_errno("cannot remove", path, errno);
  }
};

}  // namespace

FileSystem& real_file_system() {
  static RealFileSystem file_system;
  return file_system;
}

}  // namespace phiz
