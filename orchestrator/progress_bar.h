#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <ostream>
#include <string>

#include "orchestrator/outcome.h"

namespace phiz {

/// One line at the bottom of a terminal: how far the step is, its residual, the time left. Not thread-safe.
class ProgressBar {
 public:
  explicit ProgressBar(std::ostream& out) : out_(out) {}
  ~ProgressBar() { erase(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void begin(std::size_t subject_count) { subject_count_ = subject_count; }
  void start(const StepPlace& place);
  void update(const StepPlace& place, double fraction,
              std::optional<double> residual);  ///< drawn ten times a second
  void end(const StepPlace& place);
  void count_subject() { ++finished_subjects_; }
  void erase();  ///< before anything else is written to the terminal

  /// The line itself, without control codes. `elapsed_seconds` is that of the step.
  std::string format(const StepPlace& place, double fraction, std::optional<double> residual,
                     double elapsed_seconds) const;

 private:
  using Clock = std::chrono::steady_clock;
  std::ostream& out_;
  std::size_t subject_count_ = 1, finished_subjects_ = 0;
  std::map<std::string, Clock::time_point> started_;  // subject -> start of its step
  Clock::time_point last_drawn_{};
  bool is_drawn_ = false;
};

}  // namespace phiz
