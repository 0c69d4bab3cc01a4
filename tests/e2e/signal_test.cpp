// SIGINT and SIGTERM: the program stops within a second, says how to go on, and goes on.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <thread>

#include "tests/e2e/subject.h"
#include "tests/support/random.h"
#include "tests/support/temp_folder.h"

namespace phiz::test {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// `phiz fit` on its own, with stderr in a file.
pid_t start_fit(const FittedSubject& subject, const std::filesystem::path& store,
                const std::filesystem::path& err) {
  std::fflush(nullptr);
  const pid_t child = ::fork();
  if (child != 0) return child;
  if (::freopen(err.c_str(), "w", stderr) == nullptr || ::freopen("/dev/null", "w", stdout) == nullptr)
    ::_exit(99);
  const std::string program = phiz_program().string();
  ::execl(program.c_str(), program.c_str(), "fit", subject.scan.c_str(), "--store", store.c_str(),
          static_cast<char*>(nullptr));
  ::_exit(99);
}

struct Ending {
  int code = -1;
  double seconds = 0;  // from the last signal
};

Ending signal_and_wait(pid_t child, double after_s, const std::vector<int>& signals) {
  std::this_thread::sleep_for(std::chrono::duration<double>(after_s));
  Clock::time_point begin;
  for (const int signal : signals) {
    begin = Clock::now();
    ::kill(child, signal);
    std::this_thread::sleep_for(std::chrono::milliseconds(signals.size() > 1 ? 20 : 0));
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), seconds_since(begin)};
}

TEST(Signals, StopWithinASecondSayHowToContinueAndTheSameCommandDoes) {
  const FittedSubject subject = fitted_subject();
  const std::string digests = list_digests(subject.store);
  const TempFolder folder;
  for (const int signal : {SIGINT, SIGTERM, SIGINT, SIGTERM}) {
    const std::filesystem::path store = folder / "store", err = folder / "err";
    std::filesystem::remove_all(store);
    const Ending ending =
        signal_and_wait(start_fit(subject, store, err), random().uniform(0.3, 1.2), {signal});
    EXPECT_TRUE(ending.code == 128 + signal || ending.code == 0) << ending.code;
    EXPECT_LT(ending.seconds, 1.0 + 0.5) << "half a second for a busy machine";
    const std::string said = read_bytes(err);
    const bool says_how = said.find("run the same command to continue") != std::string::npos;
    EXPECT_TRUE(ending.code == 0 || says_how) << said;
    EXPECT_EQ(run_phiz(store, {"fit", subject.scan.string(), "-q"}).exit_code, 0);
    EXPECT_EQ(list_digests(store), digests);
  }
}

TEST(Signals, ASecondSigintStopsAtOnce) {
  const FittedSubject subject = fitted_subject();
  const TempFolder folder;
  const Ending ending =
      signal_and_wait(start_fit(subject, folder / "store", folder / "err"), 0.6, {SIGINT, SIGINT});
  EXPECT_EQ(ending.code, 130);
  EXPECT_LT(ending.seconds, 0.3);
  EXPECT_EQ(run_phiz(folder / "store", {"store", "verify"}).exit_code, 0);
}

}  // namespace
}  // namespace phiz::test
