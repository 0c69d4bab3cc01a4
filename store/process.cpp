#include "store/process.h"

#include <signal.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <sstream>

namespace phiz {
namespace {

std::string read_first_line(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

std::string read_link(const char* path) {
  std::array<char, 256> target{};
  const ssize_t length = ::readlink(path, target.data(), target.size());
  return length > 0 ? std::string(target.data(), static_cast<std::size_t>(length)) : std::string();
}

struct ProcessState {
  char code = 0;            // R, S, D, Z ...; 0: no such process
  std::uint64_t start = 0;  // field 22 of /proc/PID/stat
};

ProcessState read_state(std::int64_t pid) {
  const std::string line = read_first_line("/proc/" + std::to_string(pid) + "/stat");
  const std::size_t name_end = line.rfind(')');  // the name may hold spaces and parentheses
  if (name_end == std::string::npos) return {};
  std::istringstream fields(line.substr(name_end + 1));
  ProcessState state;
  fields >> state.code;
  std::string skipped;
  for (int field = 4; field < 22; ++field) fields >> skipped;
  fields >> state.start;
  return state;
}

class RealProcesses final : public Processes {
 public:
  ProcessIdentity self() override {
    static const std::string place = host_name() + "/" + read_first_line("/proc/sys/kernel/random/boot_id") +
                                     "/" + read_link("/proc/self/ns/pid");
    return {place, ::getpid(), read_state(::getpid()).start};
  }

  bool is_alive(const ProcessIdentity& identity) override {
    if (identity.pid <= 0) return false;
    if (::kill(static_cast<pid_t>(identity.pid), 0) != 0 && errno == ESRCH) return false;
    const ProcessState state = read_state(identity.pid);
    const bool is_ours_to_see = state.code != 0;
    if (!is_ours_to_see) return true;  // exists, but /proc does not tell: assume the best
    return state.code != 'Z' && state.code != 'X' && state.start == identity.start;
  }

  double now_seconds() override {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }
};

}  // namespace

Processes& real_processes() {
  static RealProcesses processes;
  return processes;
}

std::string host_name() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) return "unknown";
  return name.data();
}

}  // namespace phiz
