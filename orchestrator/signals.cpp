#include "orchestrator/signals.h"

#include <signal.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <string>
#include <thread>

namespace phiz {
namespace {

constexpr std::chrono::milliseconds kGrace{800};

StopFlag stop_flag;
int wake_pipe[2] = {-1, -1};

void write_text(int fd, const std::string& text) {
  [[maybe_unused]] const ssize_t written = ::write(fd, text.data(), text.size());
}

extern "C" void handle_stop_signal(int signal) {
  if (stop_flag.signal() != 0) ::_exit(128 + signal);
  stop_flag.request(signal);
  const char wake = 0;
  [[maybe_unused]] const ssize_t written = ::write(wake_pipe[1], &wake, 1);
}

/// Sleeps until a signal came and the grace is over.
void watch(bool is_json) {
  std::array<char, 1> byte{};
  while (::read(wake_pipe[0], byte.data(), 1) < 0) continue;
  std::this_thread::sleep_for(kGrace);
  const int code = 128 + stop_flag.signal();
  if (::isatty(STDERR_FILENO) == 1) write_text(STDERR_FILENO, "\r\x1b[K");  // a progress bar may stand there
  write_text(STDERR_FILENO, "error: interrupted\nhint: run the same command to continue\n");
  if (is_json) write_text(STDOUT_FILENO, "{\"type\":\"exit\",\"code\":" + std::to_string(code) + "}\n");
  ::_exit(code);
}

}  // namespace

StopFlag& install_stop_signals(bool is_json) {
  if (::pipe(wake_pipe) == 0) {
    std::thread(watch, is_json).detach();
    struct sigaction action {};
    action.sa_handler = handle_stop_signal;
    ::sigaction(SIGINT, &action, nullptr);
    ::sigaction(SIGTERM, &action, nullptr);
  }
  return stop_flag;
}

}  // namespace phiz
