#include "orchestrator/executors/slurm.h"

#include <algorithm>
#include <charconv>
#include <set>
#include <sstream>

#include "orchestrator/error.h"
#include "orchestrator/error_table.h"

namespace phiz {
namespace {

constexpr int kNotThere = 127;

bool is_job_id(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

std::size_t find_max_array_size(const RunChild& run, std::size_t otherwise) {
  const ChildAnswer answer = run({"scontrol", "show", "config"});
  const std::string name = "MaxArraySize";
  const std::size_t at = answer.out.find(name);
  if (answer.exit_code != 0 || at == std::string::npos) return otherwise;
  const std::size_t digits = answer.out.find_first_not_of(" =", at + name.size());
  if (digits == std::string::npos) return otherwise;
  std::size_t value = 0;
  std::from_chars(answer.out.data() + digits, answer.out.data() + answer.out.size(), value);
  return value > 1 ? value : otherwise;
}

std::vector<std::string> list_jobs_in_queue(const RunChild& run, const std::vector<std::string>& ids) {
  std::set<std::string> there;
  for (const std::string& id : ids) {  // one that is forgotten makes squeue fail for all
    std::istringstream lines(run({"squeue", "--noheader", "--jobs=" + id, "--format=%A %F"}).out);
    for (std::string job, array; lines >> job >> array;) there.insert(array);
  }
  std::vector<std::string> found;
  for (const std::string& id : ids) {
    if (there.contains(id)) found.push_back(id);
  }
  return found;
}

std::string submit_job(const RunChild& run, const std::string& script, const std::string& dependency) {
  std::vector<std::string> argv = {"sbatch", "--parsable"};
  // Otherwise a job whose condition can no longer come true would wait for ever.
  if (!dependency.empty()) argv.insert(argv.end(), {dependency, "--kill-on-invalid-dep=yes"});
  argv.push_back(script);
  const ChildAnswer answer = run(argv);
  if (answer.exit_code == kNotThere)
    throw UsageError("cannot run sbatch: " + to_one_line(answer.err),
                     "--executor slurm needs Slurm's programs here");
  std::string id = answer.out.substr(0, answer.out.find_first_of(";\n"));
  if (answer.exit_code != 0 || !is_job_id(id)) {
    std::string said = answer.err.empty() ? answer.out : answer.err;
    while (said.ends_with('\n')) said.pop_back();
    throw UsageError("sbatch refused " + script + ": " + to_one_line(said));
  }
  return id;
}

}  // namespace phiz
