#include "formats/readers/file_bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>

#include "formats/error.h"

namespace phiz::readers {
namespace {

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

[[noreturn]] void fail_to_open(int code) {
  switch (code) {
    case ENOENT:
    case ENOTDIR:
      throw FormatError("no such file", "check the path");
    case EACCES:
    case EPERM:
      throw FormatError("no permission to read", "chmod +r, or run as a user who may read it");
    case EISDIR:
      throw FormatError("is a directory, not a scan", "name one file in it");
    default:
      throw FormatError(std::string("cannot be opened: ") + std::strerror(code));
  }
}

std::size_t read_up_to(int fd, std::byte* target, std::size_t size) {
  std::size_t done = 0;
  while (done < size) {
    const ssize_t count = ::read(fd, target + done, std::min<std::size_t>(size - done, std::size_t{1} << 30));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0)
      throw FormatError(std::string("cannot be read: ") + std::strerror(errno) + " (byte " +
                        std::to_string(done) + ")");
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  return done;
}

FileBytes read_pipe(int fd) {
  FileBytes file;
  std::size_t capacity = std::size_t{1} << 20;
  file.data = std::make_unique_for_overwrite<std::byte[]>(capacity);
  while (true) {
    file.size += read_up_to(fd, file.data.get() + file.size, capacity - file.size);
    if (file.size < capacity) return file;
    auto larger = std::make_unique_for_overwrite<std::byte[]>(2 * capacity);
    std::memcpy(larger.get(), file.data.get(), file.size);
    file.data = std::move(larger);
    capacity *= 2;
  }
}

FileBytes read_regular(int fd, std::size_t size) {
  FileBytes file;
  file.data = std::make_unique_for_overwrite<std::byte[]>(size);
  file.size = read_up_to(fd, file.data.get(), size);
  if (file.size < size)
    throw FormatError("shrank while it was read (byte " + std::to_string(file.size) + ")",
                      "wait until its writer is done");
  return file;
}

}  // namespace

FileBytes read_file_bytes(const std::filesystem::path& path) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) fail_to_open(errno);
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) fail_to_open(errno);
  if (S_ISDIR(status.st_mode)) fail_to_open(EISDIR);
  try {
    if (!S_ISREG(status.st_mode) && !S_ISFIFO(status.st_mode))
      throw FormatError("is a device, not a scan", "name a file");
    FileBytes bytes = S_ISFIFO(status.st_mode)
                          ? read_pipe(file.get())
                          : read_regular(file.get(), static_cast<std::size_t>(status.st_size));
    if (bytes.size == 0) throw FormatError("is empty (byte 0)", "was the scan saved to the end?");
    return bytes;
  } catch (const std::bad_alloc&) {
    throw FormatError("does not fit in memory (" + std::to_string(status.st_size) + " bytes)",
                      "thin the scan first");
  }
}

}  // namespace phiz::readers
