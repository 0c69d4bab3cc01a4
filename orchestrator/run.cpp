#include "orchestrator/run.h"

#include <sys/resource.h>

#include <chrono>
#include <thread>

#include "orchestrator/run_context.h"
#include "orchestrator/version.h"
#include "store/error.h"

namespace phiz {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

std::uint64_t peak_memory_bytes() {
  rusage usage{};
  return ::getrusage(RUSAGE_SELF, &usage) == 0 ? static_cast<std::uint64_t>(usage.ru_maxrss) * 1024 : 0;
}

/// One subject on its way through the stages.
class SubjectRun {
 public:
  SubjectRun(const SubjectJob& job, const RunOptions& options, const RunServices& services)
      : job_(job), options_(options), services_(services), begin_(Clock::now()) {
    outcome_.subject = job.subject;
  }

  SubjectOutcome run() {
    try {
      run_healing();
    } catch (const EngineNeeded&) {
      throw;
    } catch (...) {
      fail();
    }
    outcome_.seconds = seconds_since(begin_);
    services_.reporter.subject_finished(outcome_);
    return std::move(outcome_);
  }

 private:
  struct Step {
    const Task& task;
    ParameterValues parameters;
    InputDigests inputs;
    KeyText key_text;
    Digest key;
  };

  void fail() {
    outcome_.failure = describe_failure(std::current_exception());
    outcome_.failed_stage = stage_;
    services_.reporter.failure({job_.subject, stage_}, *outcome_.failure);
  }

  /// An input that turns out damaged has been set aside by the store: start over, and it is computed anew.
  void run_healing() {
    constexpr int kMaxRounds = 4;
    for (int round = 1;; ++round) {
      try {
        return run_stages();
      } catch (const StoreError& error) {
        const bool can_heal = error.fault() == StoreFault::kDamaged || error.fault() == StoreFault::kMissing;
        if (!can_heal || round == kMaxRounds || stage_.empty()) throw;
        services_.reporter.warning({job_.subject, stage_}, std::string(error.what()) + ": computing it anew");
        outcome_.steps.clear();
        results_.clear();
      }
    }
  }

  void run_stages() {
    stage_.clear();
    load_record();
    for (const Task* task : services_.pipeline.closure(options_.last_stage, options_.extra_stages)) {
      stage_ = task->name;
      services_.stop.throw_if_requested();
      run_step(*task);
      if (outcome_.steps.back().result) results_[task->name] = *outcome_.steps.back().result;
    }
    stage_.clear();
    if (!options_.is_dry_run && record_ != former_) services_.store.save_subject(record_);
    if (services_.reporter.wants_summaries()) read_summaries();
  }

  void load_record() {
    former_ = {};
    try {
      if (auto record = services_.store.find_subject(job_.subject)) former_ = std::move(*record);
    } catch (const StoreError& error) {
      if (error.fault() != StoreFault::kDamaged) throw;
      services_.reporter.warning({job_.subject, ""}, std::string(error.what()) + ": writing it anew");
    }
    ScanInput known;
    if (!options_.reads_scans) known = {{}, {}, former_.scan_digest, former_.scan_bytes, former_.scan_stamp};
    scan_ = hash_scan(services_.store.files(), job_.scan, known);
    record_ = former_;
    record_.name = job_.subject;
    record_.scan_path = std::filesystem::absolute(job_.scan).lexically_normal().string();
    record_.scan_digest = scan_.digest;
    record_.scan_bytes = scan_.size_bytes;
    record_.scan_stamp = scan_.stamp;
  }

  /// Nothing if an earlier stage would have to be computed first (dry run).
  std::optional<Step> prepare(const Task& task) const {
    InputDigests inputs;
    for (const TaskInput& input : task.inputs) {
      switch (input.kind) {
        case TaskInput::Kind::kScan:
          inputs.digests[input.name] = scan_.digest;
          inputs.scan_extension = scan_.extension;
          break;
        case TaskInput::Kind::kTemplateMesh:
          inputs.digests[input.name] = services_.head.mesh_digest;
          break;
        case TaskInput::Kind::kTemplateAnnotations:
          inputs.digests[input.name] = services_.head.annotations_digest;
          break;
        case TaskInput::Kind::kOutput: {
          const auto result = results_.find(input.stage);
          if (result == results_.end()) return std::nullopt;
          inputs.digests[input.name] = result->second.outputs.at(input.output).digest;
        }
      }
    }
    ParameterValues parameters = resolve_parameters(task.parameters, task.name, job_.settings);
    KeyText key_text = make_key_text(task, parameters, inputs);
    const Digest key = key_text.key();
    return Step{task, std::move(parameters), std::move(inputs), std::move(key_text), key};
  }

  void run_step(const Task& task) {
    const auto step = prepare(task);
    const StepPlace place{job_.subject, task.name};
    if (!step)
      return finish(place,
                    {task.name, StepOutcome::Status::kWouldCompute, "an earlier stage is computed", {}});
    if (auto result = find_noted_result(*step)) return keep(place, *step, std::move(*result));
    if (auto result = services_.store.find_done_result(step->key))
      return keep(place, *step, std::move(*result));
    const std::string reason = explain(*step);
    if (options_.is_dry_run)
      return finish(place, {task.name, StepOutcome::Status::kWouldCompute, reason, {}});
    if (!task.run) throw EngineNeeded();
    const auto lease = wait_for_lease(*step);
    if (!lease) return keep(place, *step, services_.store.find_done_result(step->key).value());
    // Whoever had the lease before may have finished between our look and our turn.
    if (auto result = services_.store.find_done_result(step->key))
      return keep(place, *step, std::move(*result));
    compute(place, *step, reason);
  }

  /// The result as the subject's record remembers it, if its file is that very file, whole, and the outputs
  /// are there. Parses nothing.
  std::optional<Result> find_noted_result(const Step& step) const {
    const ResultNote* note = former_.find_note(step.task.name);
    if (note == nullptr || note->key != step.key) return std::nullopt;
    if (!services_.store.has(*note, Store::Care::kCheck)) return std::nullopt;
    Result result{step.key_text, note->outputs, {}, note->seal};
    result.run.seconds = note->seconds;
    return result;
  }

  void keep(const StepPlace& place, const Step& step, Result result) {
    const ResultNote* note = former_.find_note(step.task.name);
    const bool is_noted = note != nullptr && note->key == step.key && note->seal == result.seal;
    if (!is_noted) record_.set_current(step.task.name, make_note(result));
    if (!is_noted && !options_.is_dry_run) claim(step);
    // Left behind by a process killed between its commit and this line.
    if (!options_.is_dry_run) Checkpoint(services_.store, step.key).remove();
    finish(place, {step.task.name, StepOutcome::Status::kKept, {}, std::move(result)});
  }

  /// A result that has become current is named by the record, and then looked for once more: whoever collects
  /// garbage has either read the name or taken the result away before we look.
  void claim(const Step& step) {
    const auto former = former_.results.find(step.task.name);
    if (former != former_.results.end() && former->second == step.key) return;
    services_.store.save_subject(record_);
    if (!services_.store.has(*record_.find_note(step.task.name), Store::Care::kLook)) {
      throw StoreError(StoreFault::kMissing, "result " + step.key.hex() + " was removed meanwhile");
    }
  }

  void finish(const StepPlace& place, StepOutcome outcome) {
    outcome_.steps.push_back(std::move(outcome));
    services_.reporter.step_finished(place, outcome_.steps.back());
  }

  /// Why the step has no result, in words.
  std::string explain(const Step& step) const {
    const auto there = services_.store.find_result(step.key);
    if (there) {
      std::string names;
      for (const std::string& name : services_.store.list_missing_outputs(*there)) names += " " + name;
      return "its result is there but not its output" + names;
    }
    const auto former_key = former_.results.find(step.task.name);
    if (former_key == former_.results.end()) return "no result yet";
    if (former_key->second == step.key) return "its result is missing";
    const auto former = services_.store.find_result(former_key->second);
    if (!former) return "the former result is missing";
    return describe_differences(compare_keys(former->key_text, step.key_text));
  }

  /// The lease; nothing if another process finished the result while we waited.
  std::optional<Lease> wait_for_lease(const Step& step) {
    bool has_said_so = false;
    for (;;) {
      auto answer = services_.leases.try_acquire(step.key);
      if (auto* lease = std::get_if<Lease>(&answer)) return std::move(*lease);
      const LeaseHolder& holder = std::get<LeaseHolder>(answer);
      const std::string who = "process " + std::to_string(holder.pid) + " on " + holder.host;
      if (!options_.waits_for_leases) {
        throw StoreError(StoreFault::kLeaseHeld, who + " is computing it now",
                         "wait for it, or leave out --no-wait");
      }
      if (!has_said_so) services_.reporter.note({job_.subject, step.task.name}, "waiting for " + who);
      has_said_so = true;
      services_.stop.throw_if_requested();
      std::this_thread::sleep_for(std::chrono::duration<double>(options_.lease_poll_seconds));
      if (services_.store.find_done_result(step.key)) return std::nullopt;
    }
  }

  void compute(const StepPlace& place, const Step& step, const std::string& reason) {
    services_.reporter.step_started(place, reason);
    const auto begin = Clock::now();
    RunContext context({services_.store, step.task, scan_, services_.head, step.parameters,
                        step.inputs.digests, services_.reporter, services_.stop, memo_, place, step.key});
    step.task.run(context);
    CommitRequest request;
    request.outputs = context.take_outputs();
    request.result.key_text = step.key_text;
    request.result.run = {seconds_since(begin), peak_memory_bytes(), host_name(), kVersion, reason};
    for (const TaskInput& input : step.task.inputs) {
      if (input.kind == TaskInput::Kind::kTemplateMesh) request.inputs_to_keep.push_back(services_.head.mesh);
      if (input.kind == TaskInput::Kind::kTemplateAnnotations) {
        request.inputs_to_keep.push_back(services_.head.annotations);
      }
    }
    record_.set_current(step.task.name, step.key);
    request.subject = record_;
    CommitOutcome committed = services_.store.commit(std::move(request));
    record_.set_current(step.task.name, make_note(committed.result));
    context.checkpoint().remove();
    if (committed.differed) {
      services_.reporter.warning(place,
                                 "a finished result of the same key has other bytes; that one was kept");
    }
    finish(place, {step.task.name, StepOutcome::Status::kComputed, reason, std::move(committed.result),
                   seconds_since(begin)});
  }

  void read_summaries() {
    for (const auto& [stage, result] : results_) {
      const std::string& name = services_.pipeline.get(stage).summary;
      if (name.empty()) continue;
      outcome_.summaries[stage] = services_.store.read_object(result.outputs.at(name).digest);
    }
  }

  const SubjectJob& job_;
  const RunOptions& options_;
  const RunServices& services_;
  const Clock::time_point begin_;
  SubjectOutcome outcome_;
  std::string stage_;  // where we are, for messages
  ScanInput scan_;
  SubjectRecord former_, record_;
  std::map<std::string, Result> results_;
  Memo memo_;
};

}  // namespace

SubjectOutcome run_subject(const SubjectJob& job, const RunOptions& options, const RunServices& services) {
  return SubjectRun(job, options, services).run();
}

bool is_hopeless(const Failure& failure) {
  return failure.code == kExitDisk;
}

int exit_code_of(const std::vector<SubjectOutcome>& outcomes, std::size_t job_count, const StopFlag& stop) {
  if (stop.signal() != 0) return 128 + stop.signal();
  int failed = 0, code = kExitDone;
  for (const SubjectOutcome& outcome : outcomes) {
    if (!outcome.failure) continue;
    if (is_hopeless(*outcome.failure)) return outcome.failure->code;
    ++failed;
    code = outcome.failure->code;
  }
  if (failed == 0) return kExitDone;
  return job_count == 1 ? code : kExitSomeFailed;
}

}  // namespace phiz
