#include <mutex>
#include <nlohmann/json.hpp>

#include "orchestrator/report.h"

namespace phiz {
namespace {

using json = nlohmann::ordered_json;

const char* name_of(StepOutcome::Status status) {
  switch (status) {
    case StepOutcome::Status::kKept:
      return "kept";
    case StepOutcome::Status::kComputed:
      return "computed";
    case StepOutcome::Status::kWouldCompute:
      return "would_compute";
  }
  return "";
}

json describe(const StepOutcome& step) {
  json object = {{"stage", step.stage}, {"status", name_of(step.status)}};
  if (!step.reason.empty()) object["reason"] = step.reason;
  if (step.status == StepOutcome::Status::kComputed) object["seconds"] = step.seconds;
  if (step.result) {
    object["key"] = step.result->key().hex();
    for (const auto& [name, output] : step.result->outputs) {
      object["outputs"][name] = {{"digest", output.digest.hex()}, {"bytes", output.size_bytes}};
    }
  }
  return object;
}

/// One JSON object a line, `type` first: begin, step, progress, note, warning, error, subject.
class JsonReporter final : public Reporter {
 public:
  explicit JsonReporter(std::ostream& out) : out_(out) {}

  void begin(std::size_t subject_count) override { write({{"type", "begin"}, {"subjects", subject_count}}); }

  void step_started(const StepPlace& place, const std::string& reason) override {
    write({{"type", "step"},
           {"subject", place.subject},
           {"stage", place.stage},
           {"status", "started"},
           {"reason", reason}});
  }

  void step_progress(const StepPlace& place, double fraction, std::optional<double> residual) override {
    json object = {
        {"type", "progress"}, {"subject", place.subject}, {"stage", place.stage}, {"fraction", fraction}};
    if (residual) object["residual"] = *residual;
    write(object);
  }

  void step_finished(const StepPlace& place, const StepOutcome& outcome) override {
    json object = {{"type", "step"}, {"subject", place.subject}};
    object.update(describe(outcome));
    write(object);
  }

  void note(const StepPlace& place, const std::string& line) override { write_line("note", place, line); }
  void warning(const StepPlace& place, const std::string& line) override {
    write_line("warning", place, line);
  }

  void failure(const StepPlace& place, const Failure& failure) override {
    json object = {{"type", "error"}, {"code", failure.code}, {"what", failure.what}};
    if (!place.subject.empty()) object["subject"] = place.subject;
    if (!place.stage.empty()) object["stage"] = place.stage;
    if (!failure.hint.empty()) object["hint"] = failure.hint;
    write(object);
  }

  bool wants_summaries() const override { return true; }

  void subject_finished(const SubjectOutcome& outcome) override {
    json object = {{"type", "subject"},
                   {"subject", outcome.subject},
                   {"status", outcome.failure ? "failed" : "done"},
                   {"seconds", outcome.seconds}};
    if (outcome.failure) object["code"] = outcome.failure->code;
    object["steps"] = json::array();
    for (const StepOutcome& step : outcome.steps) object["steps"].push_back(describe(step));
    for (const auto& [stage, text] : outcome.summaries) {
      json summary = json::parse(text, nullptr, /*allow_exceptions=*/false);
      if (!summary.is_object()) continue;
      if (summary.contains("scan_from_head")) object["scan_from_head"] = summary["scan_from_head"];
      object["summaries"][stage] = std::move(summary);
    }
    write(object);
  }

 private:
  void write_line(const char* type, const StepPlace& place, const std::string& line) {
    write({{"type", type}, {"subject", place.subject}, {"stage", place.stage}, {"text", line}});
  }

  void write(const json& object) {
    const std::lock_guard lock(mutex_);
    out_ << object.dump(-1, ' ', false, json::error_handler_t::replace) << std::endl;
  }

  std::ostream& out_;
  std::mutex mutex_;
};

}  // namespace

std::unique_ptr<Reporter> make_json_reporter(std::ostream& out) {
  return std::make_unique<JsonReporter>(out);
}

}  // namespace phiz
