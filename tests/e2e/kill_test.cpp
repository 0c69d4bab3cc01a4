#include <gtest/gtest.h>

#include "tests/e2e/subject.h"
#include "tests/support/random.h"
#include "tests/support/temp_folder.h"

namespace phiz::test {
namespace {

constexpr int kKills = 4;

TEST(Kill, AnyInstantAndTheSameCommandGiveTheSameOutputs) {
  const FittedSubject subject = fitted_subject();
  const std::string digests = list_digests(subject.store);
  const TempFolder folder;
  const ProgramRun whole = run_phiz(folder / "whole", {"fit", subject.scan.string(), "-q"});
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  EXPECT_EQ(list_digests(folder / "whole"), digests);
  for (int kill = 0; kill < kKills; ++kill) {
    const std::filesystem::path store = folder / ("killed" + std::to_string(kill));
    ProgramOptions options;
    options.kill_after_s = random().uniform(0, whole.seconds);
    run_phiz(store, {"fit", subject.scan.string(), "-q"}, options);
    const ProgramRun again = run_phiz(store, {"fit", subject.scan.string(), "-q"});
    EXPECT_EQ(again.exit_code, 0) << "killed after " << *options.kill_after_s << " s: " << again.err;
    EXPECT_EQ(list_digests(store), digests) << "killed after " << *options.kill_after_s << " s";
    EXPECT_EQ(run_phiz(store, {"store", "verify"}).exit_code, 0);
  }
}

TEST(Threads, DoNotShowInTheOutputs) {
  const FittedSubject subject = fitted_subject();
  const TempFolder folder;
  ASSERT_EQ(run_phiz(folder / "one", {"fit", subject.scan.string(), "-q", "-j", "1"}).exit_code, 0);
  EXPECT_EQ(list_digests(folder / "one"), list_digests(subject.store));
}

}  // namespace
}  // namespace phiz::test
