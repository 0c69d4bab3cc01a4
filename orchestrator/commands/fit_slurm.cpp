#include "orchestrator/commands/fit_slurm.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>

#include "orchestrator/error.h"
#include "orchestrator/executors/slurm.h"
#include "store/error.h"
#include "store/run_log.h"
#include "store/sealed_json.h"

namespace phiz {
namespace {

using nlohmann::ordered_json;

std::string quote_field(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

/// Remembers which subjects a dry run would compute something for.
class WorkFinder final : public Reporter {
 public:
  void begin(std::size_t) override {}
  void step_started(const StepPlace&, const std::string&) override {}
  void step_progress(const StepPlace&, double, std::optional<double>) override {}
  void step_finished(const StepPlace& place, const StepOutcome& outcome) override {
    if (outcome.status == StepOutcome::Status::kWouldCompute) add(place.subject);
  }
  void note(const StepPlace&, const std::string&) override {}
  void warning(const StepPlace&, const std::string&) override {}
  void failure(const StepPlace& place, const Failure&) override {
    add(place.subject);
  }  // its task will say why
  void subject_finished(const SubjectOutcome&) override {}

  bool has(const std::string& subject) const { return subjects_.contains(subject); }

 private:
  void add(const std::string& subject) {
    const std::lock_guard lock(mutex_);
    subjects_.insert(subject);
  }
  std::mutex mutex_;
  std::set<std::string> subjects_;
};

/// Subjects that are not finished. One that the store does not know is not, and its scan need not be read for
/// that.
std::vector<SubjectJob> find_unfinished(const std::vector<SubjectJob>& jobs, RunOptions options,
                                        const TemplateFiles& head, Session& session) {
  if (!session.files().find_status(session.store_path() / "phiz-store.json")) return jobs;
  const Store store = session.open_store();
  const std::vector<std::string> known = store.list_subjects();
  std::vector<SubjectJob> to_look_at;
  for (const SubjectJob& job : jobs) {
    if (std::binary_search(known.begin(), known.end(), job.subject)) to_look_at.push_back(job);
  }
  WorkFinder finder;
  LeaseTable leases(store, session.environment().processes);
  options.is_dry_run = true;
  run_subjects(to_look_at, options,
               {store, leases, session.pipeline(), head, finder, session.environment().stop});
  session.environment().stop.throw_if_requested();
  std::vector<SubjectJob> unfinished;
  for (const SubjectJob& job : jobs) {
    const bool is_known = std::binary_search(known.begin(), known.end(), job.subject);
    if (!is_known || finder.has(job.subject)) unfinished.push_back(job);
  }
  return unfinished;
}

std::string find_program(const Session& session) {
  const std::filesystem::path folder = session.environment().program_folder;
  for (const std::filesystem::path& program : {folder / "phiz", folder / "../../bin/phiz"}) {
    if (session.files().find_status(program)) return program.lexically_normal().string();
  }
  return "phiz";
}

std::vector<std::string> make_fit_words(const RunOptions& options, const TemplateFiles& head,
                                        const Session& session) {
  std::vector<std::string> words = {"--template",
                                    std::filesystem::absolute(head.mesh_path).lexically_normal().string()};
  if (!options.last_stage.empty()) words.insert(words.end(), {"--until", options.last_stage});
  for (const std::string& stage : options.extra_stages) words.push_back(session.pipeline().get(stage).option);
  if (!options.waits_for_leases) words.push_back("--no-wait");
  if (options.fails_fast) words.push_back("--fail-fast");
  if (options.reads_scans) words.push_back("--read-scans");
  if (session.globals().max_memory)
    words.insert(words.end(), {"--max-memory", *session.globals().max_memory});
  return words;
}

/// Puts files in place and hands scripts over.
class Submission {
 public:
  Submission(const ExecutorArguments& arguments, const RunOptions& options, const TemplateFiles& head,
             Session& session)
      : arguments_(arguments), session_(session), run_(session.environment().run_child) {
    request_.program = find_program(session);
    request_.fit_words = make_fit_words(options, head, session);
    request_.store = std::filesystem::absolute(session.store_path()).lexically_normal().string();
    request_.logs = (std::filesystem::path(request_.store) / "logs").string();
    request_.folder = std::filesystem::current_path().string();
    request_.threads = options.threads;
    request_.memory_mib = (options.max_memory_bytes + (1 << 20) - 1) >> 20;
  }

  int submit(const std::vector<SubjectJob>& all, const std::vector<SubjectJob>& unfinished) {
    name_by(all);
    if (unfinished.empty() && arguments_.then.empty() && arguments_.first.empty()) {
      session_.print(fmt::format("{} subjects: nothing to do", all.size()));
      session_.print_json({{"type", "submitted"}, {"subjects", 0}, {"jobs", ordered_json::array()}});
      return kExitDone;
    }
    request_.subject_count = unfinished.size();
    const std::string list = format_subject_list(unfinished);
    request_.list = request_.logs + "/" + make_checked_name(request_.name, list, ".csv");
    request_.max_array_size = find_max_array_size(run_);
    const std::vector<SlurmJob> jobs = plan_slurm_jobs(make_options(), request_);
    if (session_.globals().is_dry_run) return show(jobs);
    const std::vector<std::string> queued = find_queued();
    if (!queued.empty()) return say_queued(queued);
    const Store store = session_.open_or_create_store();
    store.files().make_folders(request_.logs);
    write(request_.list, list);
    for (const SlurmJob& job : jobs) {
      const std::string script = script_of(job);
      write(script, job.script);
      ids_.push_back(submit_job(run_, script, format_dependency(job, ids_)));
      write(record(), seal_json({{"jobs", ids_}}));  // at once: sbatch may refuse the next one
      session_.print(fmt::format("job {}: {}", ids_.back(), job.name));
      session_.print_json({{"type", "job"}, {"job", ids_.back()}, {"name", job.name}, {"script", script}});
    }
    session_.print(fmt::format("{} of {} subjects have work left; phiz status --watch follows them",
                               unfinished.size(), all.size()));
    session_.print_json({{"type", "submitted"}, {"subjects", unfinished.size()}, {"jobs", ids_}});
    return kExitDone;
  }

 private:
  /// The same command has the same name, however much of it is done.
  void name_by(const std::vector<SubjectJob>& all) {
    std::string text = format_subject_list(all) + arguments_.sbatch_args.value_or("");
    const std::vector<std::string>* kinds[] = {&request_.fit_words, &arguments_.first, &arguments_.then};
    for (const std::vector<std::string>* words : kinds) {
      for (const std::string& word : *words) text += "\n" + word;
      text += "\n";
    }
    request_.name = "slurm-" + compute_digest(text).hex().substr(0, 12);
  }

  SlurmOptions make_options() const {
    SlurmOptions options;
    options.slice_size =
        static_cast<std::size_t>(arguments_.slice_size.value_or(static_cast<int>(options.slice_size)));
    options.at_once =
        static_cast<std::size_t>(arguments_.at_once.value_or(static_cast<int>(options.at_once)));
    options.sbatch_args = arguments_.sbatch_args.value_or("");
    options.first = arguments_.first;
    options.then = arguments_.then;
    options.goes_on_after_failures = arguments_.goes_on_after_failures;
    return options;
  }

  std::string record() const { return request_.logs + "/" + request_.name + ".json"; }
  std::string script_of(const SlurmJob& job) const {
    return request_.logs + "/" + make_checked_name(request_.name + "-" + job.name, job.script, ".sh");
  }

  void write(const std::string& file, const std::string& text) const {
    DurableWriter writer(session_.files());
    writer.add(file, std::as_bytes(std::span(text)), FileSystem::Mode::kWritable);
    writer.publish();
  }

  int show(const std::vector<SlurmJob>& jobs) const {
    std::vector<std::string> names;
    for (const SlurmJob& job : jobs) {
      const std::string dependency = format_dependency(job, names);
      names.push_back("$" + job.name);
      session_.print(fmt::format("# {}=$(sbatch --parsable {}{})", job.name,
                                 dependency.empty() ? "" : dependency + " --kill-on-invalid-dep=yes ",
                                 quote_for_shell(script_of(job))));
      session_.print(job.script);
      session_.print_json(
          {{"type", "script"}, {"name", job.name}, {"dependency", dependency}, {"script", job.script}});
    }
    return kExitDone;
  }

  std::vector<std::string> find_queued() const {
    if (!session_.files().find_status(record())) return {};
    const std::string text = session_.files().read_file(record(), 1 << 20);
    if (!is_sealed_well(text)) return {};
    const auto object = nlohmann::json::parse(text, nullptr, false);
    if (!object.is_object() || !object.contains("jobs")) return {};
    std::vector<std::string> ids;
    for (const auto& id : object["jobs"]) {
      if (id.is_string()) ids.push_back(id.get<std::string>());
    }
    return list_jobs_in_queue(run_, ids);
  }

  int say_queued(const std::vector<std::string>& ids) const {
    session_.print(fmt::format("submitted already and still in the queue: {}", fmt::join(ids, " ")));
    session_.print_json({{"type", "submitted"}, {"already", true}, {"jobs", ids}});
    return kExitDone;
  }

  const ExecutorArguments& arguments_;
  Session& session_;
  const RunChild run_;
  SlurmRequest request_;
  std::vector<std::string> ids_;
};

int check_positive(const std::optional<int>& number, const std::string& option) {
  if (number && *number < 1) throw UsageError(option + " is less than 1");
  return number.value_or(0);
}

}  // namespace

void ExecutorArguments::declare(OptionSet& options) {
  options.add_text("--executor", executor, "local (default), or slurm: submit job arrays and return");
  options.add_text("--sbatch-args", sbatch_args,
                   "slurm: options for sbatch, such as \"--partition=short --time=2:00:00\"");
  options.add_integer("--slice-size", slice_size, "slurm: subjects a task (default 100)");
  options.add_integer("--at-once", at_once, "slurm: tasks that run at a time (default 10)");
  options.add_texts("--first", first,
                    "slurm: a phiz command to run before the subjects, such as \"template build ...\"");
  options.add_texts(
      "--then", then,
      "slurm: a phiz command to run once all subjects are done; after failures only with --keep-going");
  options.add_text("--slice", slice, "only the I-th of N parts of the subjects: I/N");
}

bool ExecutorArguments::is_slurm() const {
  const std::string name = executor.value_or("local");
  if (name != "local" && name != "slurm") throw UsageError("--executor " + name + " is not local or slurm");
  const bool has_options = sbatch_args || slice_size || at_once || !first.empty() || !then.empty();
  if (name == "local" && has_options)
    throw UsageError("--sbatch-args, --slice-size, --at-once, --first and --then need --executor slurm");
  check_positive(slice_size, "--slice-size");
  check_positive(at_once, "--at-once");
  return name == "slurm";
}

void take_slice(const std::string& slice, std::vector<SubjectJob>& jobs) {
  std::size_t number = 0, count = 0;
  const char *begin = slice.data(), *end = begin + slice.size();
  const auto first = std::from_chars(begin, end, number);
  const bool has_slash = first.ec == std::errc() && first.ptr != end && *first.ptr == '/';
  const auto second = has_slash ? std::from_chars(first.ptr + 1, end, count) : first;
  if (!has_slash || second.ec != std::errc() || second.ptr != end || number < 1 || number > count ||
      count > 1 << 30) {
    throw UsageError("--slice " + slice + " is not I/N with I from 1 to N");
  }
  const std::size_t from = (number - 1) * jobs.size() / count, to = number * jobs.size() / count;
  jobs = std::vector<SubjectJob>(jobs.begin() + static_cast<std::ptrdiff_t>(from),
                                 jobs.begin() + static_cast<std::ptrdiff_t>(to));
}

std::string format_subject_list(const std::vector<SubjectJob>& jobs) {
  std::set<std::pair<std::string, std::string>> columns;
  for (const SubjectJob& job : jobs) {
    for (const auto& [stage, values] : job.settings) {
      for (const auto& [name, value] : values) columns.emplace(stage, name);
    }
  }
  std::string text = "subject,scan";
  for (const auto& [stage, name] : columns) text += "," + stage + "." + name;
  text += "\n";
  for (const SubjectJob& job : jobs) {
    text += job.subject + "," + quote_field(std::filesystem::absolute(job.scan).lexically_normal().string());
    for (const auto& [stage, name] : columns) {
      const auto values = job.settings.find(stage);
      const bool is_set = values != job.settings.end() && values->second.contains(name);
      text += "," + (is_set ? quote_field(format_value(values->second.at(name))) : std::string());
    }
    text += "\n";
  }
  return text;
}

int submit_fit(const ExecutorArguments& arguments, const std::vector<SubjectJob>& jobs,
               const RunOptions& options, const TemplateFiles& head, Session& session) {
  const std::vector<SubjectJob> unfinished =
      arguments.first.empty() ? find_unfinished(jobs, options, head, session) : jobs;
  return Submission(arguments, options, head, session).submit(jobs, unfinished);
}

}  // namespace phiz
