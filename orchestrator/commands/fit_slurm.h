#pragma once

#include <optional>
#include <string>
#include <vector>

#include "orchestrator/executors/slurm_plan.h"
#include "orchestrator/option_set.h"
#include "orchestrator/run.h"
#include "orchestrator/session.h"

namespace phiz {

/// Options of `phiz fit` about where it runs.
struct ExecutorArguments {
  std::optional<std::string> executor, sbatch_args, slice;
  std::optional<int> slice_size, at_once;
  std::vector<std::string> first, then;
  bool goes_on_after_failures = false;  ///< --keep-going was asked for

  void declare(OptionSet& options);
  bool is_slurm() const;  ///< throws UsageError for an unknown name, and for options of Slurm without it
};

/// The subjects of one slice "I/N", 1 <= I <= N: every subject is in exactly one, sizes differ by one at
/// most. Throws UsageError.
void take_slice(const std::string& slice, std::vector<SubjectJob>& jobs);

/// A list for `phiz fit --list` that gives the very same jobs, wherever it lies.
std::string format_subject_list(const std::vector<SubjectJob>& jobs);

/// Submits the subjects that have work left, as job arrays over slices of a list in the store's logs/.
/// Nothing where there is none, or where what was submitted before is still in the queue. With --dry-run
/// prints the scripts. With commands to run first, every subject: what they make may be what a fit depends
/// on. Returns the exit code.
int submit_fit(const ExecutorArguments& arguments, const std::vector<SubjectJob>& jobs,
               const RunOptions& options, const TemplateFiles& head, Session& session);

}  // namespace phiz
