#pragma once

#include <cstdint>
#include <string>

namespace phiz {

/// One running process, told apart from every other that ever had or will have its number.
struct ProcessIdentity {
  std::string place;  ///< host name, boot and process-number space: where `pid` means something
  std::int64_t pid = 0;
  std::uint64_t start = 0;  ///< start time in the kernel's ticks: tells a reused pid from its former owner
  bool operator==(const ProcessIdentity&) const = default;
};

/// What leases ask about processes and time. Tests put their own behind it.
class Processes {
 public:
  virtual ~Processes() = default;
  virtual ProcessIdentity self() = 0;
  /// Only meaningful if identity.place is self().place.
  virtual bool is_alive(const ProcessIdentity& identity) = 0;
  virtual double now_seconds() = 0;  ///< monotonic
};

Processes& real_processes();

std::string host_name();

}  // namespace phiz
