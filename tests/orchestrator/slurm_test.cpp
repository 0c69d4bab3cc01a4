// Jobs for Slurm: what is planned, and what is said to its programs. No Slurm needed.

#include "orchestrator/executors/slurm.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "orchestrator/commands/fit_slurm.h"
#include "orchestrator/error.h"
#include "orchestrator/subject_list.h"
#include "tests/orchestrator/fake_phiz.h"

namespace phiz {
namespace {

using test::FakePhiz;

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

SlurmRequest make_request(std::size_t subjects) {
  return {"/bin/phiz",
          {"--template", "/head/head.obj"},
          "/data/my store",
          "/data/my store/logs/slurm-1.csv",
          "/home/u",
          "slurm-1",
          "/data/my store/logs",
          subjects};
}

std::vector<SubjectJob> make_jobs(std::size_t count) {
  std::vector<SubjectJob> jobs;
  for (std::size_t i = 0; i < count; ++i) jobs.push_back({"s" + std::to_string(i), "/scans/s.ply", {}});
  return jobs;
}

/// A Slurm that takes every job.
struct FakeSlurm {
  std::vector<std::vector<std::string>> calls;
  std::string config = "MaxArraySize            = 1001\n", queue;
  int next_id = 100;
  int sbatch_code = 0;

  ChildAnswer run(const std::vector<std::string>& argv) {
    if (argv[0] == "scontrol") return {0, config, {}};
    if (argv[0] == "squeue") return {queue.empty() ? 1 : 0, queue, {}};
    calls.push_back(argv);
    if (sbatch_code != 0) return {sbatch_code, {}, "sbatch: error: Invalid partition\n"};
    return {0, std::to_string(next_id++) + ";cluster\n", {}};
  }
  void serve(FakePhiz& phiz) {
    phiz.run_child = [this](const std::vector<std::string>& argv) { return run(argv); };
  }
};

TEST(Slice, EverySubjectIsInExactlyOneAndSizesDifferByOneAtMost) {
  for (const std::size_t subjects : {0, 1, 7, 100, 1001}) {
    for (const std::size_t count : {1, 2, 3, 8, 150}) {
      std::vector<std::string> names;
      std::size_t smallest = subjects, largest = 0;
      for (std::size_t i = 1; i <= count; ++i) {
        std::vector<SubjectJob> jobs = make_jobs(subjects);
        take_slice(std::to_string(i) + "/" + std::to_string(count), jobs);
        for (const SubjectJob& job : jobs) names.push_back(job.subject);
        smallest = std::min(smallest, jobs.size());
        largest = std::max(largest, jobs.size());
      }
      std::vector<std::string> all;
      for (const SubjectJob& job : make_jobs(subjects)) all.push_back(job.subject);
      EXPECT_EQ(names, all);
      EXPECT_LE(largest, smallest + 1);
    }
  }
}

TEST(Slice, RefusesWhatIsNone) {
  for (const std::string bad :
       {"", "1", "0/3", "4/3", "1/0", "-1/3", "1/3x", "1//3", "/3", "99999999999999999999/3"}) {
    std::vector<SubjectJob> jobs = make_jobs(3);
    EXPECT_THROW(take_slice(bad, jobs), UsageError) << bad;
  }
}

TEST(SlurmPlan, SplitsAtMaxArraySizeAndTheArraysTogetherCoverEverySlice) {
  SlurmOptions options;
  options.slice_size = 10;
  options.at_once = 7;
  for (const std::size_t subjects : {1, 10, 11, 90, 91, 2500}) {
    SlurmRequest request = make_request(subjects);
    request.max_array_size = 10;  // indices 1 to 9
    std::size_t tasks = 0;
    for (const SlurmJob& job : plan_slurm_jobs(options, request)) {
      const std::size_t at = job.script.find("#SBATCH --array=1-") + 18;
      const std::size_t count = std::stoul(job.script.substr(at));
      EXPECT_LT(count, request.max_array_size);
      EXPECT_TRUE(contains(job.script, "%7\n"));
      const std::string number =
          tasks == 0 ? "$SLURM_ARRAY_TASK_ID" : "$((" + std::to_string(tasks) + " + SLURM_ARRAY_TASK_ID))";
      EXPECT_TRUE(
          contains(job.script, "--slice \"" + number + "/" + std::to_string((subjects + 9) / 10) + "\""))
          << job.script;
      tasks += count;
    }
    EXPECT_EQ(tasks, (subjects + 9) / 10);
  }
}

TEST(SlurmPlan, CorpusBeforeSubjectsBeforeCorpus) {
  SlurmOptions options;
  options.slice_size = 1;
  options.first = {"template build a", "template check b"};
  options.then = {"fields pca", "retarget --all"};
  SlurmRequest request = make_request(4);
  request.max_array_size = 3;
  const std::vector<SlurmJob> jobs = plan_slurm_jobs(options, request);
  const std::vector<std::string> ids = {"1", "2", "3", "4", "5", "6"};
  std::vector<std::string> said;
  for (const SlurmJob& job : jobs) said.push_back(job.name + " " + format_dependency(job, ids));
  EXPECT_EQ(said,
            (std::vector<std::string>{"first1 ", "first2 --dependency=afterok:1",
                                      "fit1 --dependency=afterok:2", "fit2 --dependency=afterok:2,afterany:3",
                                      "then1 --dependency=afterok:3:4", "then2 --dependency=afterok:5"}));
  EXPECT_TRUE(contains(jobs[4].script, "/bin/phiz fields pca --store '/data/my store'"));
  options.goes_on_after_failures = true;
  EXPECT_EQ(format_dependency(plan_slurm_jobs(options, request)[4], ids), "--dependency=afterany:3:4");
}

TEST(SlurmPlan, ScriptsQuoteWhatTheyName) {
  EXPECT_EQ(quote_for_shell("a/b-c.d"), "a/b-c.d");
  EXPECT_EQ(quote_for_shell(""), "''");
  EXPECT_EQ(quote_for_shell("it's $HOME"), "'it'\\''s $HOME'");
  SlurmOptions options;
  const std::string script = plan_slurm_jobs(options, make_request(5)).at(0).script;
  EXPECT_TRUE(contains(script, "--store '/data/my store'"));
  EXPECT_TRUE(contains(script, "#SBATCH --output=\"/data/my store/logs/slurm-1-fit1-%A_%a.txt\"\n"));
  options.sbatch_args = "--time=1\n#SBATCH --wrap=x";
  EXPECT_THROW(plan_slurm_jobs(options, make_request(5)), UsageError);
  SlurmRequest request = make_request(5);
  request.logs = "/data/100%A/logs";
  EXPECT_THROW(plan_slurm_jobs({}, request), UsageError);
}

TEST(SlurmList, GivesTheSameJobsAgain) {
  std::vector<SubjectJob> jobs = make_jobs(3);
  jobs[1].scan = "/scans/a, \"b\" and\nc.ply";
  jobs[1].settings["join"]["weight"] = 0.1 + 0.2;
  jobs[2].settings["read"]["units"] = std::string("mm");
  const auto rows = parse_subject_list(format_subject_list(jobs), "it");
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[1].fields.at("scan"), jobs[1].scan.string());
  EXPECT_EQ(rows[1].fields.at("join.weight"), format_value(0.1 + 0.2));
  EXPECT_EQ(rows[0].fields.at("join.weight"), "");
  EXPECT_EQ(rows[2].fields.at("read.units"), "mm");
}

TEST(SlurmFit, SubmitsWhatIsNotFinishedAndTheTaskDoesIt) {
  FakePhiz phiz;
  FakeSlurm slurm;
  slurm.serve(phiz);
  phiz.add_file("/scans/b.xyz", "words of another");
  phiz.add_file("/scans/list.csv", "scan,join.weight\na.xyz,2\nb.xyz,\n");
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--set", "join.weight=2"}), 0);
  EXPECT_EQ(
      phiz.run({"fit", "--list", "/scans/list.csv", "--executor", "slurm", "--look", "--until", "join"}), 2);
  EXPECT_EQ(phiz.run({"fit", "--list", "/scans/list.csv", "--executor", "slurm"}), 0) << phiz.err;
  ASSERT_EQ(slurm.calls.size(), 1u) << phiz.out;
  const std::string script = phiz.disk.read_file(slurm.calls[0].back());
  const std::size_t at = script.find("--list ") + 7;
  const std::string list = script.substr(at, script.find(' ', at) - at);
  EXPECT_EQ(parse_subject_list(phiz.disk.read_file(list), "it").size(), 1u) << "a is finished";
  EXPECT_EQ(phiz.stages.runs["join"], 1) << "submitting computes nothing";
  EXPECT_EQ(phiz.run({"fit", "--list", list, "--slice", "1/1"}), 0) << phiz.err;
  EXPECT_EQ(phiz.stages.runs["join"], 2);
  EXPECT_EQ(phiz.run({"fit", "--list", "/scans/list.csv"}), 0);
  EXPECT_EQ(phiz.stages.runs["join"], 2) << "the task's key is the one the user's command has";
  EXPECT_EQ(phiz.run({"fit", "--list", "/scans/list.csv", "--executor", "slurm"}), 0);
  EXPECT_TRUE(contains(phiz.out, "nothing to do")) << phiz.out;
  EXPECT_EQ(slurm.calls.size(), 1u);
}

TEST(SlurmFit, ADryRunPrintsTheScriptAndChangesNothing) {
  FakePhiz phiz;
  FakeSlurm slurm;
  slurm.serve(phiz);
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--executor", "slurm", "-n", "--sbatch-args",
                      "--partition=short", "--then", "fields pca"}),
            0);
  EXPECT_TRUE(contains(phiz.out, "#!/bin/bash\n#SBATCH --job-name=phiz-fit1\n#SBATCH --array=1-1%10\n"))
      << phiz.out;
  EXPECT_TRUE(contains(phiz.out, "#SBATCH --partition=short\n"));
  EXPECT_TRUE(contains(phiz.out, "--dependency=afterok:$fit1 --kill-on-invalid-dep=yes"));
  EXPECT_TRUE(slurm.calls.empty());
  EXPECT_FALSE(phiz.disk.find_status("/disk/store"));
}

TEST(SlurmFit, WhatIsInTheQueueIsNotSubmittedAgain) {
  FakePhiz phiz;
  FakeSlurm slurm;
  slurm.serve(phiz);
  const std::vector<std::string> command = {"fit", "/scans/a.xyz", "--executor", "slurm"};
  EXPECT_EQ(phiz.run(command), 0);
  slurm.queue = "101 100\n";
  EXPECT_EQ(phiz.run(command), 0);
  EXPECT_EQ(slurm.calls.size(), 1u);
  EXPECT_TRUE(contains(phiz.out, "still in the queue: 100")) << phiz.out;
  slurm.queue.clear();
  EXPECT_EQ(phiz.run(command), 0);
  EXPECT_EQ(slurm.calls.size(), 2u);
}

TEST(SlurmFit, SaysWhatSbatchSaysAndWhereThereIsNone) {
  FakePhiz phiz;
  FakeSlurm slurm;
  slurm.serve(phiz);
  slurm.sbatch_code = 1;
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--executor", "slurm"}), 2);
  EXPECT_TRUE(contains(phiz.err, "Invalid partition")) << phiz.err;
  slurm.sbatch_code = 127;
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--executor", "slurm"}), 2);
  EXPECT_TRUE(contains(phiz.err, "needs Slurm's programs")) << phiz.err;
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--executor", "cloud"}), 2);
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--at-once", "3"}), 2);
  EXPECT_EQ(phiz.run({"fit", "/scans/a.xyz", "--executor", "slurm", "--at-once", "0"}), 2);
}

TEST(ChildProgram, GivesBackWhatWasSaidHoweverMuch) {
  const ChildAnswer answer =
      run_child_program({"sh", "-c", "head -c 300000 /dev/zero; head -c 200000 /dev/zero >&2; exit 7"});
  EXPECT_EQ(answer.exit_code, 7);
  EXPECT_EQ(answer.out.size(), 300'000u);
  EXPECT_EQ(answer.err.size(), 200'000u);
  EXPECT_EQ(run_child_program({"/no/such/program"}).exit_code, 127);
}

}  // namespace
}  // namespace phiz
