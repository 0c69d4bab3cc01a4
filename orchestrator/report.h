#pragma once

#include <memory>
#include <optional>
#include <ostream>
#include <string>

#include "orchestrator/outcome.h"

namespace phiz {

/// Tells the user what happens. Calls may come from any thread. Results go to `out`, everything else to
/// `err`.
class Reporter {
 public:
  virtual ~Reporter() = default;
  virtual void begin(std::size_t subject_count) = 0;
  virtual void step_started(const StepPlace& place, const std::string& reason) = 0;
  virtual void step_progress(const StepPlace& place, double fraction, std::optional<double> residual) = 0;
  virtual void step_finished(const StepPlace& place, const StepOutcome& outcome) = 0;
  virtual void note(const StepPlace& place, const std::string& line) = 0;
  virtual void warning(const StepPlace& place, const std::string& line) = 0;
  virtual void failure(const StepPlace& place, const Failure& failure) = 0;
  virtual void subject_finished(const SubjectOutcome& outcome) = 0;
  /// After the last subject: what failed, once more, where there were several.
  virtual void end(const std::vector<SubjectOutcome>& outcomes, std::size_t subject_count) {
    static_cast<void>(outcomes), static_cast<void>(subject_count);
  }
  virtual bool wants_summaries() const { return false; }  ///< if not, SubjectOutcome::summaries may be empty
};

struct ReportOptions {
  bool is_json = false;
  bool is_quiet = false;      ///< errors and results only
  bool is_verbose = false;    ///< kept steps and reasons too
  bool has_terminal = false;  ///< draw a progress bar on err
  bool has_colour = false;
};

std::unique_ptr<Reporter> make_reporter(const ReportOptions& options, std::ostream& out, std::ostream& err);
std::unique_ptr<Reporter> make_json_reporter(std::ostream& out);

/// `error: <stage> [<subject>]: <what>` and at most one `hint:`.
std::string format_failure(const StepPlace& place, const Failure& failure, bool has_colour);

/// "0.84 s", "12 s", "3 min 05 s", "2 h 10 min".
std::string format_duration(double seconds);

}  // namespace phiz
