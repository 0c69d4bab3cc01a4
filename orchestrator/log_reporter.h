#pragma once

#include "orchestrator/report.h"
#include "store/run_log.h"

namespace phiz {

/// Tells another reporter everything, and the store's log what was computed and what failed. Work that was
/// finished before leaves no line.
class LogReporter final : public Reporter {
 public:
  LogReporter(Reporter& next, RunLog& log) : next_(next), log_(log) {}
  void begin(std::size_t subject_count) override { next_.begin(subject_count); }
  void step_started(const StepPlace& place, const std::string& reason) override;
  void step_progress(const StepPlace& place, double fraction, std::optional<double> residual) override {
    next_.step_progress(place, fraction, residual);
  }
  void step_finished(const StepPlace& place, const StepOutcome& outcome) override;
  void note(const StepPlace& place, const std::string& line) override { next_.note(place, line); }
  void warning(const StepPlace& place, const std::string& line) override;
  void failure(const StepPlace& place, const Failure& failure) override;
  void subject_finished(const SubjectOutcome& outcome) override { next_.subject_finished(outcome); }
  void end(const std::vector<SubjectOutcome>& outcomes, std::size_t subject_count) override {
    next_.end(outcomes, subject_count);
  }
  bool wants_summaries() const override { return next_.wants_summaries(); }

 private:
  void write(const StepPlace& place, const std::string& event, const std::string& text);
  Reporter& next_;
  RunLog& log_;
};

}  // namespace phiz
