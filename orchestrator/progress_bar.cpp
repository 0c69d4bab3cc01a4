#include "orchestrator/progress_bar.h"

#include <fmt/format.h>

#include <algorithm>

#include "orchestrator/report.h"

namespace phiz {
namespace {

constexpr int kBarWidth = 24;
constexpr double kRedrawSeconds = 0.1;
constexpr double kSmallestFractionForAnEstimate = 0.03;

double seconds_between(std::chrono::steady_clock::time_point begin,
                       std::chrono::steady_clock::time_point end) {
  return std::chrono::duration<double>(end - begin).count();
}

}  // namespace

void ProgressBar::start(const StepPlace& place) {
  started_[place.subject] = Clock::now();
  last_drawn_ = {};
  update(place, 0, {});
}

void ProgressBar::update(const StepPlace& place, double fraction, std::optional<double> residual) {
  const auto now = Clock::now();
  if (seconds_between(last_drawn_, now) < kRedrawSeconds) return;
  last_drawn_ = now;
  out_ << '\r' << format(place, fraction, residual, seconds_between(started_[place.subject], now)) << "\x1b[K"
       << std::flush;
  is_drawn_ = true;
}

void ProgressBar::end(const StepPlace& place) {
  started_.erase(place.subject);
}

void ProgressBar::erase() {
  if (is_drawn_) out_ << "\r\x1b[K" << std::flush;
  is_drawn_ = false;
}

std::string ProgressBar::format(const StepPlace& place, double fraction, std::optional<double> residual,
                                double elapsed_seconds) const {
  fraction = std::clamp(fraction, 0.0, 1.0);
  const int filled = static_cast<int>(fraction * kBarWidth);
  std::string line;
  if (subject_count_ > 1) line += fmt::format("[{}/{}] ", finished_subjects_, subject_count_);
  line += fmt::format("{} {} [{}{}] {:3.0f} %", place.subject, place.stage, std::string(filled, '#'),
                      std::string(kBarWidth - filled, '.'), 100 * fraction);
  if (residual) line += fmt::format("  residual {:.4g}", *residual);
  if (fraction > kSmallestFractionForAnEstimate) {
    line += "  " + format_duration(elapsed_seconds * (1 - fraction) / fraction) + " left";
  }
  return line;
}

}  // namespace phiz
