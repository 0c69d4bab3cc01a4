// `phiz fit --executor slurm` on a real Slurm that the test starts: arrays, a node that is killed, cancelled
// jobs, time that runs out. Whatever happens, the same command ends with the outputs of an undisturbed local
// run.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <memory>
#include <set>
#include <thread>

#include "tests/e2e/slurm_cluster.h"
#include "tests/e2e/subject.h"
#include "tests/support/temp_folder.h"

namespace phiz::test {
namespace {

namespace fs = std::filesystem;

constexpr int kSubjects = 5;

class Slurm : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string obstacle = SlurmCluster::find_obstacle();
    if (!obstacle.empty()) GTEST_SKIP() << obstacle;
    const ProgramRun made = run_program({phiz_program().string(), "synth", "-o", (folder_ / "synth").string(),
                                         "-q", "--points", "60000", "--subjects", std::to_string(kSubjects)});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    std::ofstream list(folder_ / "list.csv");
    list << "scan\n";
    for (int i = 1; i <= kSubjects; ++i) list << "synth/scans/synth00" << i << ".ply\n";
    list.close();
    ASSERT_EQ(run_phiz(folder_ / "local", {"fit", "--list", list_file(), "-q"}).exit_code, 0);
    cluster_ = std::make_unique<SlurmCluster>(3);  // two tasks an array
  }

  std::string list_file() const { return folder_ / "list.csv"; }
  fs::path store() const { return folder_ / "store"; }

  ProgramRun submit(std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {"fit",   "--list",       list_file(), "--executor",
                                      "slurm", "--slice-size", "1"};
    words.insert(words.end(), more.begin(), more.end());
    return run_phiz(store(), words);
  }

  std::size_t count_results() const {
    const fs::path results = store() / "results";
    if (!fs::exists(results)) return 0;
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(results), fs::directory_iterator()));
  }

  /// Until it holds, or two minutes are over.
  bool wait_until(const std::function<bool()>& holds) const {
    for (int i = 0; i < 2400; ++i) {
      if (holds()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
  }

  bool wait_until_queue_is_empty() const {
    return wait_until([&] {
      cluster_->release_requeued();
      return cluster_->list_queue().empty();
    });
  }

  /// "<array>_<task>" and node of a task that runs.
  std::pair<std::string, std::string> find_running() const {
    for (const std::string& line : cluster_->list_queue()) {
      const std::size_t at = line.find(" RUNNING ");
      if (at != std::string::npos) return {line.substr(0, at), line.substr(at + 9)};
    }
    return {};
  }

  std::string read_task_outputs() const {
    std::string text;
    for (const auto& entry : fs::directory_iterator(store() / "logs")) {
      if (entry.path().extension() == ".txt") text += read_bytes(entry.path());
    }
    return text;
  }

  void expect_all_is_well() const {
    EXPECT_EQ(list_digests(store()), list_digests(folder_ / "local"));
    const ProgramRun verify = run_phiz(store(), {"store", "verify"});
    EXPECT_EQ(verify.exit_code, 0) << verify.out;
    EXPECT_TRUE(fs::is_empty(store() / "leases"));
    const ProgramRun status = run_phiz(store(), {"status"});
    EXPECT_EQ(count_lines(status.out, "synth00"), kSubjects) << status.out;
    EXPECT_EQ(status.out.find("none"), std::string::npos) << status.out;
    const ProgramRun again = submit();
    EXPECT_NE(again.out.find("nothing to do"), std::string::npos) << again.out << again.err;
  }

  const TempFolder folder_;
  std::unique_ptr<SlurmCluster> cluster_;
};

TEST_F(Slurm, ArraysSplitAtMaxArraySizeGiveWhatALocalRunGivesAndTheCorpusComesAfter) {
  const std::string mark = folder_ / "pack.tar";
  const ProgramRun submitted = submit({"--sbatch-args", "--comment=\"two words\" --time=10", "--at-once", "2",
                                       "--then", "store pack synth001 synth005 -o " + mark});
  ASSERT_EQ(submitted.exit_code, 0) << submitted.err;
  EXPECT_EQ(count_lines(submitted.out, "job "), 4) << "arrays of 2, 2 and 1, and the command after them";
  EXPECT_NE(submit({"--sbatch-args", "--comment=\"two words\" --time=10", "--at-once", "2", "--then",
                    "store pack synth001 synth005 -o " + mark})
                .out.find("still in the queue"),
            std::string::npos);
  EXPECT_TRUE(wait_until_queue_is_empty());
  EXPECT_TRUE(fs::exists(mark)) << read_task_outputs();
  expect_all_is_well();
}

TEST_F(Slurm, ANodeKilledInTheMiddleLosesNothing) {
  ASSERT_EQ(submit().exit_code, 0);
  ASSERT_TRUE(wait_until([&] { return count_results() >= 2 && !find_running().first.empty(); }));
  const std::string node = find_running().second;
  cluster_->kill_node(node);
  EXPECT_LT(count_results(), 5u * kSubjects) << "in the middle";
  EXPECT_TRUE(wait_until([&] {
    return cluster_->ask({"sinfo", "-h", "-n", node, "-o", "%T"}).starts_with("down");
  }));
  EXPECT_TRUE(wait_until_queue_is_empty()) << "the other node takes over";
  expect_all_is_well();
}

TEST_F(Slurm, ACancelledJobLeavesASoundStoreAndTheSameCommandContinues) {
  ASSERT_EQ(submit().exit_code, 0);
  ASSERT_TRUE(wait_until([&] { return count_results() >= 2 && !find_running().first.empty(); }));
  const std::string task = find_running().first, job = task.substr(0, task.find('_'));
  for (const std::string& line : cluster_->list_queue())
    cluster_->ask({"scancel", line.substr(0, line.find('_'))});
  EXPECT_TRUE(wait_until([&] { return cluster_->list_queue().empty(); }));
  EXPECT_EQ(run_phiz(store(), {"store", "verify"}).exit_code, 0);
  EXPECT_LT(count_results(), 5u * kSubjects) << "cancelled in the middle";
  ASSERT_EQ(submit().exit_code, 0);
  EXPECT_TRUE(wait_until_queue_is_empty());
  expect_all_is_well();
}

TEST_F(Slurm, ATaskWhoseTimeIsOverGoesBackIntoTheQueueAndContinues) {
  ASSERT_EQ(submit().exit_code, 0);
  ASSERT_TRUE(wait_until([&] { return count_results() >= 1 && !find_running().first.empty(); }));
  std::string task;
  // What Slurm sends a minute before the end. A task that ends just then has not heard it.
  ASSERT_TRUE(wait_until([&] {
    task = find_running().first;
    if (!task.empty()) cluster_->ask({"scancel", "--batch", "--signal=USR1", task});
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    return read_task_outputs().find("out of time") != std::string::npos;
  }));
  EXPECT_TRUE(wait_until_queue_is_empty());
  expect_all_is_well();
}

}  // namespace
}  // namespace phiz::test
