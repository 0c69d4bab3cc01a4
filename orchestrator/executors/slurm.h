#pragma once

#include <functional>
#include <string>
#include <vector>

#include "orchestrator/child_program.h"
#include "orchestrator/executors/slurm_plan.h"

namespace phiz {

/// The door to Slurm's programs.
using RunChild = std::function<ChildAnswer(const std::vector<std::string>& argv)>;

/// MaxArraySize of the cluster, by `scontrol show config`; `otherwise` where it does not say.
std::size_t find_max_array_size(const RunChild& run, std::size_t otherwise = 1001);

/// Those of the jobs that wait or run, by `squeue`. Empty where Slurm does not know them any more.
std::vector<std::string> list_jobs_in_queue(const RunChild& run, const std::vector<std::string>& ids);

/// `sbatch` of a script in a file. Returns the job's id. Throws UsageError with what sbatch said, or with a
/// hint where there is no Slurm.
std::string submit_job(const RunChild& run, const std::string& script, const std::string& dependency);

}  // namespace phiz
