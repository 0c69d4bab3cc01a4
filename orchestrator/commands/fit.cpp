#include <memory>
#include <set>

#include "formats/error.h"
#include "orchestrator/commands/commands.h"
#include "orchestrator/commands/fit_slurm.h"
#include "orchestrator/error.h"
#include "orchestrator/log_reporter.h"
#include "orchestrator/option_set.h"
#include "orchestrator/quantity.h"
#include "orchestrator/run.h"
#include "orchestrator/session.h"
#include "orchestrator/subject_list.h"
#include "store/error.h"

namespace phiz {
namespace {

/// A parameter that has an option of its own, such as --units.
struct Shortcut {
  std::string stage;
  Parameter parameter;
  std::optional<std::string> text;
  std::string label() const { return parameter.option; }
  std::string column() const { return parameter.option.substr(2); }
};

/// A stage that runs only where asked for, such as --views.
struct ExtraStage {
  std::string name;
  bool is_asked_for = false;
};

struct FitArguments {
  std::vector<std::string> scans;
  std::optional<std::string> list, subject, head, last_stage;
  std::vector<std::string> assignments;
  bool does_not_wait = false, fails_fast = false, keeps_going = false, reads_scans = false;
  std::vector<Shortcut> shortcuts;
  std::vector<ExtraStage> extras;
  ExecutorArguments executor;
};

class JobMaker {
 public:
  JobMaker(const FitArguments& arguments, const Session& session)
      : arguments_(arguments), session_(session) {}

  std::vector<SubjectJob> make() {
    for (const Shortcut& shortcut : arguments_.shortcuts) {
      if (shortcut.text) apply(shortcut, *shortcut.text, shortcut.label(), common_);
    }
    for (const std::string& assignment : arguments_.assignments) {
      session_.pipeline().add_setting(assignment, common_);
    }
    if (arguments_.subject && (arguments_.scans.size() != 1 || arguments_.list)) {
      throw UsageError("--subject names one subject, so it needs exactly one SCAN");
    }
    for (const std::string& scan : arguments_.scans) {
      const std::filesystem::path path = scan;
      add(arguments_.subject.value_or(make_subject_name(path.stem().string())), path, common_);
    }
    if (arguments_.list) add_list(*arguments_.list);
    if (jobs_.empty()) throw UsageError("no scan named", "phiz fit SCAN... or phiz fit --list subjects.csv");
    if (arguments_.executor.slice) take_slice(*arguments_.executor.slice, jobs_);
    return std::move(jobs_);
  }

 private:
  static void apply(const Shortcut& shortcut, const std::string& text, const std::string& label,
                    Settings& settings) {
    settings[shortcut.stage][shortcut.parameter.name] = parse_value(shortcut.parameter, text, label);
  }

  void add(const std::string& subject, const std::filesystem::path& scan, const Settings& settings) {
    validate_subject_name(subject);
    if (!names_.insert(subject).second) {
      throw UsageError("two scans for the subject '" + subject + "'",
                       "name them apart with --subject or in a --list");
    }
    jobs_.push_back({subject, scan, settings});
  }

  std::string read_list(const std::string& file) const {
    try {
      return session_.files().read_file(file, 1 << 28);
    } catch (const StoreError& error) {
      throw UsageError(error.what());
    }
  }

  void add_list(const std::string& file) {
    const std::filesystem::path folder = std::filesystem::path(file).parent_path();
    for (SubjectListRow& row : parse_subject_list(read_list(file), file)) {
      const std::filesystem::path scan =
          folder / row.fields.extract("scan").mapped();  // an absolute one stays
      std::string subject;
      if (auto field = row.fields.extract("subject")) subject = std::move(field.mapped());
      Settings settings = common_;
      const std::string place = file + " line " + std::to_string(row.line);
      for (const auto& [column, text] : row.fields) set_field(column, text, place, settings);
      add(subject.empty() ? make_subject_name(scan.stem().string()) : subject, scan, settings);
    }
  }

  void set_field(const std::string& column, const std::string& text, const std::string& place,
                 Settings& settings) {
    for (const Shortcut& shortcut : arguments_.shortcuts) {
      if (shortcut.column() != column) continue;
      if (!text.empty()) apply(shortcut, text, place + ": " + column, settings);
      return;
    }
    if (column.find('.') == std::string::npos) throw UsageError(place + ": unknown column '" + column + "'");
    if (!text.empty()) session_.pipeline().add_setting(column + "=" + text, settings);
  }

  const FitArguments& arguments_;
  const Session& session_;
  Settings common_;
  std::vector<SubjectJob> jobs_;
  std::set<std::string> names_;
};

/// A dry run where there is no store: everything would be computed.
int preview_without_store(const std::vector<SubjectJob>& jobs, const RunOptions& options, Session& session) {
  int code = kExitDone;
  for (const SubjectJob& job : jobs) {
    SubjectOutcome outcome;
    outcome.subject = job.subject;
    try {
      hash_scan(session.files(), job.scan);
      for (const Task* task : session.pipeline().closure(options.last_stage, options.extra_stages)) {
        outcome.steps.push_back({task->name, StepOutcome::Status::kWouldCompute, "no store yet", {}});
        session.reporter().step_finished({job.subject, task->name}, outcome.steps.back());
      }
    } catch (const FormatError&) {
      outcome.failure = describe_failure(std::current_exception());
      session.reporter().failure({job.subject, ""}, *outcome.failure);
      code = jobs.size() == 1 ? outcome.failure->code : kExitSomeFailed;
    }
    session.reporter().subject_finished(outcome);
  }
  return code;
}

RunOptions make_run_options(const FitArguments& arguments, const Session& session) {
  RunOptions options;
  options.last_stage = arguments.last_stage.value_or("");
  for (const ExtraStage& extra : arguments.extras) {
    if (!extra.is_asked_for) continue;
    if (arguments.last_stage) {
      throw UsageError("--until and " + session.pipeline().get(extra.name).option + " exclude each other",
                       "--until " + extra.name + " runs what it needs");
    }
    options.extra_stages.push_back(extra.name);
  }
  options.threads = session.globals().threads.value_or(0);
  options.is_dry_run = session.globals().is_dry_run;
  options.waits_for_leases = !arguments.does_not_wait;
  if (arguments.fails_fast && arguments.keeps_going) {
    throw UsageError("--fail-fast and --keep-going exclude each other", "--keep-going is the default");
  }
  options.fails_fast = arguments.fails_fast;
  options.reads_scans = arguments.reads_scans;
  if (session.globals().max_memory)
    options.max_memory_bytes = parse_bytes(*session.globals().max_memory, "--max-memory");
  session.pipeline().closure(options.last_stage);  // an unknown stage is a usage error before anything runs
  return options;
}

int run_on_slurm(const FitArguments& arguments, const std::vector<SubjectJob>& jobs,
                 const RunOptions& options, Session& session) {
  if (session.environment().is_front) throw EngineNeeded();  // it may take a while, and heeds signals
  ExecutorArguments executor = arguments.executor;
  executor.goes_on_after_failures = arguments.keeps_going;
  if (!executor.first.empty() &&
      arguments.head) {  // a generic head that is made by then need not be there now
    TemplateFiles later;
    later.mesh_path = *arguments.head;
    return submit_fit(executor, jobs, options, later, session);
  }
  return submit_fit(executor, jobs, options, session.load_head(arguments.head), session);
}

int run_fit(const FitArguments& arguments, Session& session) {
  const bool is_slurm = arguments.executor.is_slurm();
  const std::vector<SubjectJob> jobs = JobMaker(arguments, session).make();
  const RunOptions options = make_run_options(arguments, session);
  if (is_slurm) return run_on_slurm(arguments, jobs, options, session);
  const TemplateFiles head = session.load_head(arguments.head);
  const bool has_store = session.files().find_status(session.store_path() / "phiz-store.json").has_value();
  if (options.is_dry_run && !has_store) return preview_without_store(jobs, options, session);

  const Store store = session.open_or_create_store();
  LeaseTable leases(store, session.environment().processes);
  const StopFlag& stop = session.environment().stop;
  RunLog log(store, session.environment().processes.self());
  LogReporter reporter(session.reporter(), log);
  const auto outcomes =
      run_subjects(jobs, options, {store, leases, session.pipeline(), head, reporter, stop});
  return exit_code_of(outcomes, jobs.size(), stop);
}

}  // namespace

Command make_fit_command() {
  Command command{"fit", "fit the generic head to scans, stage by stage; finished work is kept", {}, {}};
  command.declare = [](OptionSet& options, const Environment& environment) -> Command::Action {
    auto arguments = std::make_shared<FitArguments>();
    options.add_positionals("SCAN", arguments->scans, "scan files: ply obj stl off xyz pts csv glb drc vdb");
    options.add_text("--list", arguments->list,
                     "CSV of subjects: a header line with `scan`, and `subject` if wanted");
    options.add_text("--subject", arguments->subject, "name of the subject (default: the file's name)");
    options.add_text("--template", arguments->head, "the generic head's .obj, its .json beside it");
    options.add_texts("--set", arguments->assignments,
                      "stage.param=value, may be repeated; see phiz explain");
    options.add_text("--until", arguments->last_stage, "stop after this stage");
    options.add_flag("--no-wait", arguments->does_not_wait, "fail if another process computes the same now");
    options.add_flag("--fail-fast", arguments->fails_fast, "start no further subject after a failure");
    options.add_flag("--keep-going", arguments->keeps_going,
                     "go on with other subjects after a failure (default)");
    arguments->executor.declare(options);
    options.add_flag("--read-scans", arguments->reads_scans,
                     "read every scan, also those whose length and times are as they were");
    for (const Task& task : environment.pipeline.tasks()) {
      for (const Parameter& parameter : task.parameters) {
        if (!parameter.option.empty()) arguments->shortcuts.push_back({task.name, parameter, {}});
      }
      if (!task.option.empty()) arguments->extras.push_back({task.name});
    }
    for (ExtraStage& extra : arguments->extras) {
      const Task& task = environment.pipeline.get(extra.name);
      options.add_flag(task.option, extra.is_asked_for, "also make " + task.doc + "; see phiz export --view");
    }
    for (Shortcut& shortcut : arguments->shortcuts) {
      options.add_text(shortcut.label(), shortcut.text,
                       shortcut.parameter.doc + " (" + describe_type(shortcut.parameter) + ")");
    }
    return [arguments](Session& session) { return run_fit(*arguments, session); };
  };
  return command;
}

}  // namespace phiz
