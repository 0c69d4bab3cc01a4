#include "stages/geometry/powell.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

constexpr double kResolution = 0x1p-10;  ///< of the initial steps: no line search looks closer
constexpr double kFineStep = 0x1p-4;     ///< nothing gained with steps up to this: converged
constexpr double kSecondStep = 1;        ///< first steps of the axes' last word
constexpr double kGolden = 1.618033988749895;
constexpr int kMaxExpansions = 24;
constexpr int kMaxRefinements = 8;
constexpr double kLineTolerance = 0.25;  ///< of the step: a line search ends within this share of it

/// Works in units of the initial steps. Remembers how often it was asked.
class Objective {
 public:
  Objective(const std::function<double(const Eigen::VectorXd&)>& function, const Eigen::VectorXd& start,
            const PowellOptions& options)
      : function_(function), start_(start), options_(options) {}

  double at(const Eigen::VectorXd& place) {
    ++evaluations_;
    const double value = function_(parameters(place));
    return std::isnan(value) ? std::numeric_limits<double>::infinity() : value;
  }
  Eigen::VectorXd parameters(const Eigen::VectorXd& place) const {
    return start_ + place.cwiseProduct(options_.initial_steps);
  }
  int evaluations() const { return evaluations_; }
  bool exhausted() const { return evaluations_ >= options_.max_evaluations; }

 private:
  const std::function<double(const Eigen::VectorXd&)>& function_;
  const Eigen::VectorXd& start_;
  const PowellOptions& options_;
  int evaluations_ = 0;
};

struct Place {
  Eigen::VectorXd at;
  double value = 0;
};

struct Sample {
  double t = 0, value = 0;
};

/// Where the parabola through three samples is lowest, NaN if it has no such place.
double lowest_of_parabola(const Sample& a, const Sample& b, const Sample& c) {
  const double from_a = (b.t - a.t) * (b.value - c.value), from_c = (b.t - c.t) * (b.value - a.value);
  const double bend = from_a - from_c;
  if (!std::isfinite(bend) || bend == 0) return std::numeric_limits<double>::quiet_NaN();
  return b.t - 0.5 * ((b.t - a.t) * from_a - (b.t - c.t) * from_c) / bend;
}

/// Minimises along place + t direction, t = 0 known. First a bracket low - middle - high round the lowest
/// sample, by steps that grow from `step`; then parabolas within it (Brent 1973, ch. 5), golden sections
/// where a parabola does not help. Returns the lowest sample.
class LineSearch {
 public:
  LineSearch(Objective& objective, const Place& place, const Eigen::VectorXd& direction)
      : objective_(objective), place_(place), direction_(direction) {}

  Sample minimise(double step) {
    bracket(step);
    refine(std::max(kResolution, kLineTolerance * step));
    return middle_;
  }

 private:
  Sample sample(double t) { return {t, objective_.at(place_.at + t * direction_)}; }

  void bracket(double step) {
    low_ = middle_ = {0, place_.value};
    high_ = sample(step);
    if (!(high_.value < middle_.value)) {
      low_ = high_;
      high_ = sample(-step);
    }
    // From here on `high` is the end that is walked, whichever its sign.
    for (int i = 0; high_.value < middle_.value && i < kMaxExpansions && !objective_.exhausted(); ++i) {
      const double stride = kGolden * (high_.t - middle_.t);
      low_ = middle_;
      middle_ = high_;
      high_ = sample(middle_.t + stride);
    }
    if (high_.value < middle_.value) middle_ = high_;
  }

  void refine(double tolerance) {
    for (int i = 0; i < kMaxRefinements && !objective_.exhausted(); ++i) {
      if (low_.value == middle_.value && middle_.value == high_.value) return;  // a plateau
      const double reach = std::max(std::abs(low_.t - middle_.t), std::abs(high_.t - middle_.t));
      if (reach <= tolerance) return;
      double t = lowest_of_parabola(low_, middle_, high_);
      if (std::abs(t - middle_.t) < tolerance && std::isfinite(t)) {
        if (i > 0 || std::abs(t - middle_.t) < kResolution) return;
      }
      const double left = std::min(low_.t, high_.t), right = std::max(low_.t, high_.t);
      if (!(t > left && t < right) || std::abs(t - middle_.t) < kResolution) {
        const Sample& wider = std::abs(low_.t - middle_.t) > std::abs(high_.t - middle_.t) ? low_ : high_;
        t = middle_.t + (wider.t - middle_.t) * (2 - kGolden);
      }
      place(sample(t));
    }
  }

  void place(const Sample& next) {
    Sample& side = (next.t < middle_.t) == (low_.t < middle_.t) ? low_ : high_;
    Sample& other = &side == &low_ ? high_ : low_;
    if (next.value < middle_.value) {
      other = middle_;
      middle_ = next;
    } else {
      side = next;
    }
  }

  Objective& objective_;
  const Place& place_;
  const Eigen::VectorXd& direction_;
  Sample low_, middle_, high_;
};

class Powell {
 public:
  Powell(Objective& objective, int dimensions)
      : objective_(objective), dimensions_(dimensions), best_{Eigen::VectorXd::Zero(dimensions), 0} {
    best_.value = objective_.at(best_.at);
    reset_directions();
  }

  /// One line search along each direction, then one along their sum, which may replace a direction. Returns
  /// the gain.
  double round() {
    const Place before = best_;
    double largest_gain = 0;
    int largest = 0;
    for (int i = 0; i < dimensions_ && !objective_.exhausted(); ++i) {
      const double gain = search(directions_.col(i), steps_[i]);
      if (gain > largest_gain) largest_gain = gain, largest = i;
    }
    if (dimensions_ > 1 && largest_gain > 0) search_sum(before, largest_gain, largest);
    return before.value - best_.value;
  }

  void reset_directions() {
    directions_ = Eigen::MatrixXd::Identity(dimensions_, dimensions_);
    are_axes_ = true;
  }
  void set_steps(double step) { steps_ = Eigen::VectorXd::Constant(dimensions_, step); }
  double largest_step() const { return steps_.maxCoeff(); }
  bool are_axes() const { return are_axes_; }
  const Place& best() const { return best_; }

 private:
  /// The next search along the direction begins with a step like the one just made; a search that found
  /// nothing begins much closer next time.
  double search(const Eigen::VectorXd& direction, double& step) {
    const Sample lowest = LineSearch(objective_, best_, direction).minimise(step);
    const double gain = best_.value - lowest.value;
    if (lowest.t != 0) {
      best_.at += lowest.t * direction;
      best_.value = lowest.value;
      step = std::clamp(std::abs(lowest.t), 0.25 * step, 4 * step);
    } else {
      step *= 0.25;
    }
    step = std::max(step, kResolution);
    return gain;
  }

  /// Powell's new direction, taken in place of the one of the largest gain where that keeps the set
  /// independent (Press et al., Numerical Recipes, 10.7).
  void search_sum(const Place& before, double largest_gain, int largest) {
    if (objective_.exhausted()) return;
    const Eigen::VectorXd moved = best_.at - before.at;
    const double length = moved.norm();
    if (length < kResolution) return;
    const Place far{best_.at + moved, objective_.at(best_.at + moved)};
    if (!(far.value < before.value)) return;
    const double gain = before.value - best_.value, rest = gain - largest_gain;
    const double bend = before.value - 2 * best_.value + far.value;
    const double span = before.value - far.value;
    if (!(2 * bend * rest * rest < largest_gain * span * span)) return;
    if (far.value < best_.value) best_ = far;
    double step = length;
    const Eigen::VectorXd direction = moved / length;
    search(direction, step);
    directions_.col(largest) = directions_.col(dimensions_ - 1);
    steps_[largest] = steps_[dimensions_ - 1];
    directions_.col(dimensions_ - 1) = direction;
    steps_[dimensions_ - 1] = step;
    are_axes_ = false;
  }

  Objective& objective_;
  int dimensions_;
  Place best_;
  Eigen::MatrixXd directions_;
  Eigen::VectorXd steps_;
  bool are_axes_ = true;
};

}  // namespace

PowellResult minimise_powell(const std::function<double(const Eigen::VectorXd&)>& function,
                             const Eigen::VectorXd& start, const PowellOptions& options) {
  CONTRACT(options.initial_steps.size() == start.size() && start.size() > 0);
  CONTRACT((options.initial_steps.array() > 0).all() && options.max_evaluations > 0);
  Objective objective(function, start, options);
  Powell powell(objective, static_cast<int>(start.size()));
  powell.set_steps(1);
  bool converged = false;
  while (!objective.exhausted()) {
    const bool fine = powell.largest_step() <= kFineStep;
    const double before = powell.best().value, gain = powell.round();
    if (gain > options.relative_tolerance * std::abs(before)) continue;
    if (!fine) continue;  // the steps have not shrunk yet
    if (powell.are_axes()) {
      converged = true;
      break;
    }
    powell.reset_directions();  // directions may have become dependent: the axes have the last word
    powell.set_steps(kSecondStep);
  }
  return {objective.parameters(powell.best().at), powell.best().value, objective.evaluations(), converged};
}

}  // namespace phiz
