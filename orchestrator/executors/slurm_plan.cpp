#include "orchestrator/executors/slurm_plan.h"

#include <fmt/format.h>

#include <algorithm>

#include "orchestrator/error.h"

namespace phiz {
namespace {

constexpr int kMaxRestarts = 100;  // of one task: who never gets further must not go round for ever

/// Told of the end of its time, phiz stops at a safe point, and the task starts over where that was.
constexpr const char* kRun = R"(
is_late=
child=
# Slurm says so a minute before the time limit: phiz stops at its next safe point, and the task goes back into the queue.
on_time_limit() {
  is_late=yes
  [ -z "$child" ] || kill -TERM "$child" 2>/dev/null
}
trap on_time_limit USR1

@COMMAND@ &
child=$!
wait "$child"
code=$?
if [ -n "$is_late" ]; then  # the signal has ended the wait; phiz itself ends a moment later
  wait "$child"
  late=$?
  [ "$late" = 127 ] || code=$late
  task="${SLURM_ARRAY_JOB_ID:+${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID}"
  if [ "$code" = 143 ] && [ "${SLURM_RESTART_COUNT:-0}" -lt @RESTARTS@ ]; then
    echo "out of time: back into the queue, to continue there"
    scontrol requeue "${task:-$SLURM_JOB_ID}"
  fi
fi
exit "$code"
)";

std::string replaced(std::string text, const std::string& mark, const std::string& by) {
  return text.replace(text.find(mark), mark.size(), by);
}

void require_one_line(const std::string& text, const std::string& what) {
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < ' '; };
  if (std::any_of(text.begin(), text.end(), is_control)) throw UsageError(what + " holds a line break");
}

class Planner {
 public:
  Planner(const SlurmOptions& options, const SlurmRequest& request) : options_(options), request_(request) {}

  std::vector<SlurmJob> plan() {
    check();
    for (std::size_t i = 0; i < options_.first.size(); ++i) {
      add_command(fmt::format("first{}", i + 1), options_.first[i]);
      if (i > 0) jobs_.back().after = {{i - 1, true}};
    }
    add_arrays();
    const std::size_t first_array = options_.first.size(), end_of_arrays = jobs_.size();
    for (std::size_t i = 0; i < options_.then.size(); ++i) {
      add_command(fmt::format("then{}", i + 1), options_.then[i]);
      std::vector<SlurmJob::After>& after = jobs_.back().after;
      if (i > 0) {
        after.push_back({jobs_.size() - 2, true});
      } else {
        for (std::size_t array = first_array; array < end_of_arrays; ++array)
          after.push_back({array, !options_.goes_on_after_failures});
      }
    }
    return std::move(jobs_);
  }

 private:
  void check() const {
    require_one_line(options_.sbatch_args, "--sbatch-args");
    for (const std::string& command : options_.first) require_one_line(command, "--first");
    for (const std::string& command : options_.then) require_one_line(command, "--then");
    // Slurm reads % and \ in the names of files, and ends a directive at a line break.
    for (const std::string& path : {request_.logs, request_.folder}) {
      require_one_line(path, path);
      if (path.find_first_of("%\\\"") != std::string::npos)
        throw UsageError(path + ": Slurm cannot name files in such a folder",
                         "use a --store without % \\ \"");
    }
  }

  std::string head(const std::string& name, const std::string& array) const {
    std::string text = "#!/bin/bash\n";
    const auto add = [&](const std::string& directive) { text += "#SBATCH " + directive + "\n"; };
    add("--job-name=phiz-" + name);
    if (!array.empty()) add("--array=" + array);
    add("--requeue");
    add("--open-mode=append");
    add("--signal=B:USR1@60");
    add(fmt::format("--output=\"{}/{}-{}-{}.txt\"", request_.logs, request_.name, name,
                    array.empty() ? "%j" : "%A_%a"));
    add(fmt::format("--chdir=\"{}\"", request_.folder));
    if (request_.threads > 0) add(fmt::format("--cpus-per-task={}", request_.threads));
    if (request_.memory_mib > 0) add(fmt::format("--mem={}M", request_.memory_mib));
    if (!options_.sbatch_args.empty()) add(options_.sbatch_args);
    return text;
  }

  void add_job(const std::string& name, const std::string& array, const std::string& command) {
    const std::string run = replaced(kRun, "@RESTARTS@", std::to_string(kMaxRestarts));
    jobs_.push_back({name, head(name, array) + replaced(run, "@COMMAND@", command), {}});
  }

  std::string threads() const {
    return request_.threads > 0 ? std::to_string(request_.threads) : "\"${SLURM_CPUS_ON_NODE:-1}\"";
  }

  void add_command(const std::string& name, const std::string& command) {
    add_job(name, {},
            quote_for_shell(request_.program) + " " + command + " --store " +
                quote_for_shell(request_.store) + " -j " + threads());
  }

  void add_arrays() {
    const std::size_t slices = (request_.subject_count + options_.slice_size - 1) / options_.slice_size;
    const std::size_t most = std::max<std::size_t>(2, request_.max_array_size) - 1;  // indices 1 to most
    std::string words;
    for (const std::string& word : request_.fit_words) words += " " + quote_for_shell(word);
    for (std::size_t begin = 0, number = 1; begin < slices; begin += most, ++number) {
      const std::size_t count = std::min(most, slices - begin);
      const std::string slice =
          begin == 0 ? "$SLURM_ARRAY_TASK_ID" : fmt::format("$(({} + SLURM_ARRAY_TASK_ID))", begin);
      add_job(fmt::format("fit{}", number), fmt::format("1-{}%{}", count, options_.at_once),
              fmt::format("{} fit --list {} --slice \"{}/{}\" --store {}{} -j {}",
                          quote_for_shell(request_.program), quote_for_shell(request_.list), slice, slices,
                          quote_for_shell(request_.store), words, threads()));
      std::vector<SlurmJob::After>& after = jobs_.back().after;
      if (!options_.first.empty()) after.push_back({options_.first.size() - 1, true});
      if (number > 1) after.push_back({jobs_.size() - 2, false});
    }
  }

  const SlurmOptions& options_;
  const SlurmRequest& request_;
  std::vector<SlurmJob> jobs_;
};

}  // namespace

std::vector<SlurmJob> plan_slurm_jobs(const SlurmOptions& options, const SlurmRequest& request) {
  return Planner(options, request).plan();
}

std::string format_dependency(const SlurmJob& job, const std::vector<std::string>& ids) {
  std::string ok, any;
  for (const SlurmJob::After& after : job.after) (after.needs_success ? ok : any) += ":" + ids.at(after.job);
  if (ok.empty() && any.empty()) return {};
  std::string text = "--dependency=";
  if (!ok.empty()) text += "afterok" + ok;
  if (!any.empty()) text += (ok.empty() ? "afterany" : ",afterany") + any;
  return text;
}

std::string quote_for_shell(const std::string& word) {
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("_-./=,:+@").find(c) != std::string_view::npos;
  };
  if (!word.empty() && std::all_of(word.begin(), word.end(), is_plain)) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace phiz
