#include "orchestrator/log_reporter.h"

#include <fmt/chrono.h>
#include <unistd.h>

#include <chrono>

#include "store/process.h"

namespace phiz {

void LogReporter::write(const StepPlace& place, const std::string& event, const std::string& text) {
  const auto now = std::chrono::time_point_cast<std::chrono::milliseconds>(std::chrono::system_clock::now());
  const auto milliseconds = now.time_since_epoch().count() % 1000;
  log_.append(fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z {}:{} {} {} {} {}",
                          fmt::gmtime(std::chrono::system_clock::to_time_t(now)), milliseconds, host_name(),
                          ::getpid(), place.subject.empty() ? "-" : place.subject,
                          place.stage.empty() ? "-" : place.stage, event, text));
}

void LogReporter::step_started(const StepPlace& place, const std::string& reason) {
  write(place, "started", reason);
  next_.step_started(place, reason);
}

void LogReporter::step_finished(const StepPlace& place, const StepOutcome& outcome) {
  if (outcome.status == StepOutcome::Status::kComputed) {
    write(place, "done", fmt::format("{:.3f} s", outcome.seconds));
  }
  next_.step_finished(place, outcome);
}

void LogReporter::warning(const StepPlace& place, const std::string& line) {
  write(place, "warning", line);
  next_.warning(place, line);
}

void LogReporter::failure(const StepPlace& place, const Failure& failure) {
  write(place, "failed", fmt::format("code {}: {}", failure.code, failure.what));
  next_.failure(place, failure);
}

}  // namespace phiz
