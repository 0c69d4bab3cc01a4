#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "orchestrator/inputs.h"
#include "orchestrator/outcome.h"
#include "orchestrator/pipeline.h"
#include "orchestrator/report.h"
#include "orchestrator/stop.h"
#include "store/lease.h"
#include "store/store.h"

namespace phiz {

/// One subject to bring up to date.
struct SubjectJob {
  std::string subject;
  std::filesystem::path scan;
  Settings settings;
};

struct RunOptions {
  std::string last_stage;                      ///< stop after this one; empty: all that always run
  std::vector<std::string> extra_stages = {};  ///< and these, which run only where asked for
  int threads = 0;                             ///< of the whole run; 0: all the machine has
  bool is_dry_run = false;                     ///< say what would be computed, change nothing
  bool waits_for_leases = true;
  bool fails_fast = false;             ///< start no further subject after a failure
  bool reads_scans = false;            ///< hash every scan anew, whatever its stamp says
  std::uint64_t max_memory_bytes = 0;  ///< of the whole run; 0: no bound
  double lease_poll_seconds = 0.05;
};

/// What a run works with. References outlive it.
struct RunServices {
  const Store& store;
  LeaseTable& leases;
  const Pipeline& pipeline;
  const TemplateFiles& head;
  Reporter& reporter;
  const StopFlag& stop;
};

/// Brings one subject up to date, stage by stage: a result that is done is kept, another is computed and
/// committed before the next stage starts. Failures are told to the reporter and kept in
/// SubjectOutcome::failure; only EngineNeeded is thrown.
SubjectOutcome run_subject(const SubjectJob& job, const RunOptions& options, const RunServices& services);

/// What one subject of a scan of that length may need, for scheduling under RunOptions::max_memory_bytes.
std::uint64_t estimate_memory_bytes(std::uint64_t scan_bytes);

/// All subjects, several at a time, within `threads` and max_memory_bytes (one runs in any case); a failure
/// of one does not touch the others. Outcomes in the order of the jobs, without their steps and summaries,
/// which the reporter has had; subjects that were not started (interruption, fails_fast, a hopeless failure)
/// are left out.
std::vector<SubjectOutcome> run_subjects(const std::vector<SubjectJob>& jobs, const RunOptions& options,
                                         const RunServices& services);

/// True for a failure that awaits every other subject too: the store's disk is full or may not be written.
bool is_hopeless(const Failure& failure);

/// The code a run ends with: 0, the failure's own code for a single subject, 3 if some of several failed, 13
/// if the disk gave up, 130/143 if it was interrupted.
int exit_code_of(const std::vector<SubjectOutcome>& outcomes, std::size_t job_count, const StopFlag& stop);

}  // namespace phiz
