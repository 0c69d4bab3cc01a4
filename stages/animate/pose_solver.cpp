#include "stages/animate/pose_solver.h"

#include <algorithm>
#include <cmath>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

constexpr int kSweeps = 200;
constexpr double kHold = 1e-3;  ///< of the mean response: what nothing speaks for stays small

}  // namespace

PoseSolver::PoseSolver(Pose pose, std::span<const float> maxima, std::vector<float> weights)
    : pose_(std::move(pose)), maxima_(maxima.begin(), maxima.end()), weights_(std::move(weights)) {
  std::vector<float> inputs(maxima_.size(), 0.0f);
  pose_(inputs, rest_);
  CONTRACT(rest_.size() == weights_.size());
  const auto count = static_cast<Eigen::Index>(maxima_.size());
  responses_.resize(static_cast<Eigen::Index>(3 * rest_.size()), count);
  std::vector<Eigen::Vector3f> posed;
  for (Eigen::Index k = 0; k < count; ++k) {
    inputs[k] = std::min(maxima_[k], 1.0f);
    pose_(inputs, posed);
    for (std::size_t v = 0; v < posed.size(); ++v) posed[v] -= rest_[v];
    responses_.col(k) = weighted(posed) / double{inputs[k]};
    inputs[k] = 0;
  }
  normal_ = responses_.transpose() * responses_;
  normal_.diagonal().array() += kHold * std::max(normal_.diagonal().mean(), 1e-9);
}

Eigen::VectorXd PoseSolver::weighted(std::span<const Eigen::Vector3f> displacements) const {
  Eigen::VectorXd result(static_cast<Eigen::Index>(3 * displacements.size()));
  for (std::size_t v = 0; v < displacements.size(); ++v)
    result.segment<3>(static_cast<Eigen::Index>(3 * v)) =
        (std::sqrt(weights_[v]) * displacements[v]).cast<double>();
  return result;
}

PoseSolver::Result PoseSolver::solve(std::span<const Eigen::Vector3f> displacements_mm, int rounds) const {
  CONTRACT(displacements_mm.size() == rest_.size());
  const Eigen::VectorXd goal = weighted(displacements_mm);
  const auto count = static_cast<Eigen::Index>(maxima_.size());
  Eigen::VectorXd inputs = Eigen::VectorXd::Zero(count), left = goal;
  double total = 0;
  for (const float weight : weights_) total += double{weight};
  total = std::max(total, 1e-9);
  Result best;
  best.goal_rms_mm = best.rms_mm = std::sqrt(goal.squaredNorm() / total);
  best.inputs.assign(maxima_.size(), 0.0f);
  std::vector<Eigen::Vector3f> posed;
  for (int round = 0; round < rounds; ++round) {
    // Coordinate descent: inputs + change within their bounds.
    Eigen::VectorXd slope = responses_.transpose() * left, change = Eigen::VectorXd::Zero(count);
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      for (Eigen::Index k = 0; k < count; ++k) {
        const double wanted = change[k] + (slope[k] - normal_.row(k).dot(change)) / normal_(k, k);
        change[k] = std::clamp(inputs[k] + wanted, 0.0, double{maxima_[k]}) - inputs[k];
      }
    }
    inputs += change;
    const std::vector<float> values(inputs.data(), inputs.data() + count);
    pose_(values, posed);
    for (std::size_t v = 0; v < posed.size(); ++v) posed[v] -= rest_[v];
    left = goal - weighted(posed);
    const double rms = std::sqrt(left.squaredNorm() / total);
    if (rms < best.rms_mm) best.rms_mm = rms, best.inputs = values;
  }
  return best;
}

}  // namespace phiz
