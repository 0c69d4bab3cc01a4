#include <fmt/format.h>

#include <map>
#include <mutex>

#include "orchestrator/progress_bar.h"
#include "orchestrator/quantity.h"
#include "orchestrator/report.h"

namespace phiz {
namespace {

std::string describe_steps(const SubjectOutcome& outcome) {
  std::size_t computed = 0, waiting = 0;
  for (const StepOutcome& step : outcome.steps) {
    computed += step.status == StepOutcome::Status::kComputed;
    waiting += step.status == StepOutcome::Status::kWouldCompute;
  }
  if (waiting > 0) return fmt::format("{} of {} stages would be computed", waiting, outcome.steps.size());
  if (computed == 0) return "nothing to do";
  return fmt::format("{} of {} stages computed in {}", computed, outcome.steps.size(),
                     format_duration(outcome.seconds));
}

/// Lines for people: a log, or a log above a progress bar.
class TextReporter final : public Reporter {
 public:
  TextReporter(const ReportOptions& options, std::ostream& out, std::ostream& err)
      : options_(options), out_(out), err_(err), bar_(err) {}

  void begin(std::size_t subject_count) override {
    const std::lock_guard lock(mutex_);
    bar_.begin(subject_count);
  }

  void step_started(const StepPlace& place, const std::string& reason) override {
    const std::lock_guard lock(mutex_);
    if (options_.is_verbose) write(place.subject + ": " + place.stage + ": " + reason);
    if (has_bar()) bar_.start(place);
  }

  void step_progress(const StepPlace& place, double fraction, std::optional<double> residual) override {
    const std::lock_guard lock(mutex_);
    if (residual) residuals_[place.subject] = *residual;
    if (has_bar()) bar_.update(place, fraction, residual);
  }

  void step_finished(const StepPlace& place, const StepOutcome& outcome) override {
    const std::lock_guard lock(mutex_);
    bar_.end(place);
    const auto residual = residuals_.find(place.subject);
    const std::string residual_text =
        residual == residuals_.end() ? "" : fmt::format(", residual {:.4g}", residual->second);
    residuals_.erase(place.subject);
    switch (outcome.status) {
      case StepOutcome::Status::kKept:
        if (options_.is_verbose) write(place.subject + ": " + place.stage + ": kept");
        return;
      case StepOutcome::Status::kComputed:
        write(place.subject + ": " + place.stage + ": done in " + format_duration(outcome.seconds) +
              residual_text);
        return;
      case StepOutcome::Status::kWouldCompute:
        write(place.subject + ": " + place.stage + ": would be computed: " + outcome.reason);
        return;
    }
  }

  void note(const StepPlace& place, const std::string& line) override {
    const std::lock_guard lock(mutex_);
    write(place.subject + ": " + place.stage + ": " + line);
  }

  void warning(const StepPlace& place, const std::string& line) override {
    const std::lock_guard lock(mutex_);
    bar_.erase();
    err_ << format_failure(place, {0, line, {}}, false).replace(0, 5, "warning") << std::flush;
  }

  void failure(const StepPlace& place, const Failure& failure) override {
    const std::lock_guard lock(mutex_);
    bar_.erase();
    err_ << format_failure(place, failure, options_.has_colour) << std::flush;
  }

  void subject_finished(const SubjectOutcome& outcome) override {
    const std::lock_guard lock(mutex_);
    bar_.count_subject();
    bar_.erase();
    if (outcome.failure) return;
    std::string line = outcome.subject + ": " + describe_steps(outcome);
    if (!outcome.steps.empty() && outcome.steps.back().result) {
      for (const auto& [name, output] : outcome.steps.back().result->outputs) {
        line += ", " + name + " " + format_bytes(output.size_bytes);
      }
    }
    out_ << line << std::endl;
  }

  void end(const std::vector<SubjectOutcome>& outcomes, std::size_t subject_count) override {
    const std::lock_guard lock(mutex_);
    bar_.erase();
    if (subject_count < 2) return;
    std::size_t failed = 0;
    bool is_interrupted = false;
    std::string text;
    for (const SubjectOutcome& outcome : outcomes) {
      if (!outcome.failure) continue;
      const int code = outcome.failure->code;
      is_interrupted = is_interrupted || code == kExitInterrupted || code == kExitTerminated;
      if (code == kExitInterrupted || code == kExitTerminated) continue;
      ++failed;
      text += "  " + outcome.subject + (outcome.failed_stage.empty() ? "" : " " + outcome.failed_stage) +
              fmt::format(" (code {}): ", code) + outcome.failure->what + "\n";
    }
    if (failed > 0) text = fmt::format("{} of {} subjects failed:\n", failed, subject_count) + text;
    if (outcomes.size() < subject_count) {
      text += fmt::format("{} of {} subjects were not started{}\n", subject_count - outcomes.size(),
                          subject_count, is_interrupted ? "; run the same command to continue" : "");
    }
    err_ << text << std::flush;
  }

 private:
  bool has_bar() const { return options_.has_terminal && !options_.is_quiet; }

  void write(const std::string& line) {
    if (options_.is_quiet) return;
    bar_.erase();
    err_ << to_one_line(line) << std::endl;
  }

  const ReportOptions options_;
  std::ostream& out_;
  std::ostream& err_;
  std::mutex mutex_;
  ProgressBar bar_;
  std::map<std::string, double> residuals_;  // subject -> last residual of its step
};

}  // namespace

std::unique_ptr<Reporter> make_reporter(const ReportOptions& options, std::ostream& out, std::ostream& err) {
  if (options.is_json) return make_json_reporter(out);
  return std::make_unique<TextReporter>(options, out, err);
}

std::string format_failure(const StepPlace& place, const Failure& failure, bool has_colour) {
  std::string text = has_colour ? "\x1b[31merror:\x1b[0m " : "error: ";
  if (!place.stage.empty()) text += place.stage + " ";
  if (!place.subject.empty()) text += "[" + place.subject + "]";
  if (!place.stage.empty() || !place.subject.empty()) text += ": ";
  text += failure.what + "\n";
  if (!failure.hint.empty()) text += "hint: " + failure.hint + "\n";
  return text;
}

std::string format_duration(double seconds) {
  if (seconds < 9.95) return fmt::format("{:.2f} s", seconds);
  if (seconds < 59.5) return fmt::format("{:.0f} s", seconds);
  const long whole = static_cast<long>(seconds + 0.5);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

}  // namespace phiz
