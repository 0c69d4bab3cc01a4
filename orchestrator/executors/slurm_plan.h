#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace phiz {

/// What the user may say about the jobs.
struct SlurmOptions {
  std::size_t slice_size = 100;         ///< subjects a task; schedulers dislike many short allocations
  std::size_t at_once = 10;             ///< tasks that run at a time, the %K of the arrays
  std::string sbatch_args;              ///< "--partition=short --time=2:00:00": as they are, in every script
  std::vector<std::string> first;       ///< phiz commands over the whole corpus before the subjects, in turn
  std::vector<std::string> then;        ///< and after them
  bool goes_on_after_failures = false;  ///< the commands of `then` run though subjects failed
};

/// What is to be run. Paths are absolute: tasks run on other machines.
struct SlurmRequest {
  std::string program;                 ///< phiz
  std::vector<std::string> fit_words;  ///< options of `phiz fit` in each task, without list, slice, store, -j
  std::string store, list, folder;     ///< `folder`: where the user was
  std::string name;                    ///< of this submission: begins the names of its files
  std::string logs;                    ///< where the output of tasks goes
  std::size_t subject_count = 0;
  int threads = 0;                    ///< a task; 0: what Slurm gives it
  std::size_t memory_mib = 0;         ///< a task; 0: what the partition gives
  std::size_t max_array_size = 1001;  ///< Slurm's MaxArraySize: indices are below it
};

/// One job or job array. `after` are places in the plan of jobs that come before it.
struct SlurmJob {
  struct After {
    std::size_t job = 0;
    bool needs_success = true;  ///< afterok, else afterany
  };
  std::string name;  ///< "first1", "fit1", "then1"
  std::string script;
  std::vector<After> after;
};

/// The jobs in an order in which they can be submitted: `first` in turn; arrays over slices of the list,
/// split so that no index reaches max_array_size, one after the other so that `at_once` holds for all; `then`
/// in turn. A task is told a minute before its time is over, stops at the next safe point and goes back into
/// the queue; so does one whose node dies. Throws UsageError for text that cannot stand in a script.
std::vector<SlurmJob> plan_slurm_jobs(const SlurmOptions& options, const SlurmRequest& request);

/// "--dependency=afterok:12:13,afterany:14", given the ids of the jobs submitted so far; empty if it waits
/// for none.
std::string format_dependency(const SlurmJob& job, const std::vector<std::string>& ids);

/// A word of a shell, quoted where it must be.
std::string quote_for_shell(const std::string& word);

}  // namespace phiz
