#include "tests/e2e/program.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <system_error>
#include <thread>

extern char** environ;

namespace phiz::test {
namespace {

using Clock = std::chrono::steady_clock;

void check(int error, const char* what) {
  if (error != 0) throw std::system_error(error, std::generic_category(), what);
}

double to_seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

/// A file without a name, for what a program writes.
class Capture {
 public:
  Capture() {
    std::string name = (std::filesystem::temp_directory_path() / "phiz-output-XXXXXX").string();
    descriptor_ = ::mkstemp(name.data());
    if (descriptor_ < 0) check(errno, "mkstemp");
    ::unlink(name.c_str());
  }
  ~Capture() { ::close(descriptor_); }
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;

  int descriptor() const { return descriptor_; }
  std::string read() const {
    std::string text;
    std::array<char, 65536> block;
    ::lseek(descriptor_, 0, SEEK_SET);
    for (ssize_t size; (size = ::read(descriptor_, block.data(), block.size())) > 0;) {
      text.append(block.data(), static_cast<std::size_t>(size));
    }
    return text;
  }

 private:
  int descriptor_ = -1;
};

class SpawnActions {
 public:
  SpawnActions() { check(::posix_spawn_file_actions_init(&actions_), "posix_spawn_file_actions_init"); }
  ~SpawnActions() { ::posix_spawn_file_actions_destroy(&actions_); }
  SpawnActions(const SpawnActions&) = delete;
  SpawnActions& operator=(const SpawnActions&) = delete;
  posix_spawn_file_actions_t* get() { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_;
};

pid_t start(const std::vector<std::string>& argv, const ProgramOptions& options, const Capture& out,
            const Capture& err) {
  SpawnActions actions;
  check(::posix_spawn_file_actions_addopen(actions.get(), STDIN_FILENO, "/dev/null", O_RDONLY, 0), "stdin");
  if (options.out_file.empty()) {
    check(::posix_spawn_file_actions_adddup2(actions.get(), out.descriptor(), STDOUT_FILENO), "stdout");
  } else {
    check(::posix_spawn_file_actions_addopen(actions.get(), STDOUT_FILENO, options.out_file.c_str(),
                                             O_WRONLY | O_CREAT | O_TRUNC, 0644),
          "stdout");
  }
  check(::posix_spawn_file_actions_adddup2(actions.get(), err.descriptor(), STDERR_FILENO), "stderr");
  if (!options.folder.empty()) {
    check(::posix_spawn_file_actions_addchdir_np(actions.get(), options.folder.c_str()), "folder");
  }
  std::vector<char*> words;
  for (const std::string& word : argv) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  pid_t pid = 0;
  check(::posix_spawnp(&pid, words[0], actions.get(), nullptr, words.data(), environ), argv.front().c_str());
  return pid;
}

/// Waits for the end; kills at `deadline` if there is one.
int wait_for(pid_t pid, std::optional<Clock::time_point> deadline, rusage& usage) {
  int status = 0;
  while (deadline) {
    const pid_t ended = ::wait4(pid, &status, WNOHANG, &usage);
    if (ended == pid) return status;
    if (Clock::now() >= *deadline) {
      ::kill(pid, SIGKILL);
      break;
    }
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
  while (::wait4(pid, &status, 0, &usage) < 0) {
    if (errno != EINTR) check(errno, "wait4");
  }
  return status;
}

}  // namespace

ProgramRun run_program(const std::vector<std::string>& argv, const ProgramOptions& options) {
  const Capture out, err;
  const Clock::time_point begin = Clock::now();
  const pid_t pid = start(argv, options, out, err);
  std::optional<Clock::time_point> deadline;
  if (options.kill_after_s) {
    deadline = begin + std::chrono::duration_cast<Clock::duration>(
                           std::chrono::duration<double>(*options.kill_after_s));
  }
  rusage usage{};
  const int status = wait_for(pid, deadline, usage);
  ProgramRun run;
  run.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  run.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  run.processor_seconds = to_seconds(usage.ru_utime) + to_seconds(usage.ru_stime);
  run.peak_memory_bytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
  run.out = out.read();
  run.err = err.read();
  return run;
}

std::filesystem::path phiz_program() {
  const char* program = std::getenv("PHIZ_PROGRAM");
  return program != nullptr ? program : PHIZ_BUILT_PROGRAM;
}

}  // namespace phiz::test
