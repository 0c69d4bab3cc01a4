#include "stages/deform/learn_muscles.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "stages/geometry/normals.h"
#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

constexpr double kReachesMm[] = {12, 10, 8, 8, 6, 6, 5, 5, 4, 4, 3, 3, 3};
constexpr double kRidge = 200;         ///< mm^2 area: price of a muscle at 1
constexpr int kSparseFrom = 5;         ///< from this step on small parameters cost more
constexpr double kAlongSurface = 0.3;  ///< share of a match that also acts along the surface
constexpr double kNormalWeightMm = 10, kRobustShare = 0.35, kLeastMotionMm = 0.5;
constexpr double kJawStarts[] = {0, 0.5, 1};
constexpr const char* kJaw = "jawOpen";

struct Equations {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
  double cost = 0;
  Equations& operator+=(const Equations& other) {
    matrix += other.matrix;
    right += other.right;
    cost += other.cost;
    return *this;
  }
};

class MuscleSearch {
 public:
  MuscleSearch(const ScanSurface& scan, const Deformation& rig, const NeutralSurface& neutral,
               const std::vector<Eigen::Vector3i>& triangles, const std::vector<bool>& skip,
               const Eigen::Isometry3d& scan_from_neutral)
      : scan_(scan),
        rig_(rig),
        neutral_(neutral),
        triangles_(triangles),
        skip_(skip),
        scan_from_neutral_(scan_from_neutral),
        fields_(sample_fields(rig, neutral.uv)),
        cascade_(rig, neutral.landmarks),
        areas_(neutral.uv.size(), 0) {
    const auto& p = neutral.positions;
    for (const Eigen::Vector3i& t : triangles)
      for (const int corner : t) areas_[corner] += (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).norm() / 6;
  }

  MuscleGuess search(std::optional<std::size_t> jaw, double start) const {
    MuscleGuess guess{std::vector<double>(rig_.parameters.size(), 0.0), 0};
    if (jaw) guess.parameters[*jaw] = start;
    int step = 0;
    for (const double reach_mm : kReachesMm) {
      const Equations equations = linearise(guess.parameters, reach_mm);
      guess.cost = equations.cost;
      advance(equations, step++ >= kSparseFrom, guess.parameters);
    }
    return guess;
  }

 private:
  Equations linearise(const std::vector<double>& parameters, double reach_mm) const {
    std::vector<Eigen::Vector3d> at(neutral_.uv.size());
    std::vector<Eigen::Matrix3Xd> slopes(at.size());
    parallel_for(at.size(), 128, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const CascadePoint point = cascade_.differentiate(parameters, fields_, neutral_, i);
        at[i] = scan_from_neutral_ * point.position;
        slopes[i] = scan_from_neutral_.linear() * point.dq;
      }
    });
    const auto normals = compute_vertex_normals(std::span<const Eigen::Vector3d>(at), triangles_);
    const auto count = static_cast<Eigen::Index>(parameters.size());
    const Equations zero{Eigen::MatrixXd::Zero(count, count), Eigen::VectorXd::Zero(count), 0};
    return parallel_sum(at.size(), 1024, zero, [&](std::size_t begin, std::size_t end) {
      Equations part = zero;
      for (std::size_t i = begin; i < end; ++i)
        if (!skip_[i]) add_match(at[i], normals[i], slopes[i], areas_[i], reach_mm, part);
      return part;
    });
  }

  void add_match(const Eigen::Vector3d& at, const Eigen::Vector3d& normal, const Eigen::Matrix3Xd& slopes,
                 double area, double reach_mm, Equations& equations) const {
    const double size = slopes.norm();
    const auto nearest = scan_.find_match(at.cast<float>(), normal.cast<float>(),
                                          static_cast<float>(kNormalWeightMm), static_cast<float>(reach_mm));
    if (nearest.surfel_idx < 0) {
      if (size > kLeastMotionMm) equations.cost += area;
      return;
    }
    const Surfel& surfel = scan_.surfels()[nearest.surfel_idx];
    if (surfel.border > 0.8f && nearest.distance > 1.5f) return;
    const Eigen::Vector3d n = (surfel.normal.cast<double>() + normal).normalized();
    const Eigen::Vector3d to_scan = surfel.position.cast<double>() - at;
    const double offset = n.dot(to_scan), relative = offset / (kRobustShare * reach_mm);
    const double squared = relative * relative;
    equations.cost += area * squared / (1 + squared);
    if (size < 0.01) return;
    const double weight = area * (0.1 + surfel.confidence) / std::pow(1 + squared, 2);
    const double along = kAlongSurface * weight;
    const Eigen::Matrix3d metric = along * Eigen::Matrix3d::Identity() + (weight - along) * n * n.transpose();
    equations.matrix += slopes.transpose() * metric * slopes;
    equations.right += slopes.transpose() * (metric * to_scan);
  }

  /// One step within the bounds: parameters that would leave them are set there and the rest solved again.
  void advance(const Equations& equations, bool prefers_few, std::vector<double>& parameters) const {
    const std::size_t count = parameters.size();
    std::vector<bool> is_fixed(count, false);
    Eigen::VectorXd step = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(count));
    for (int round = 0; round < 8; ++round) {
      Eigen::MatrixXd matrix = equations.matrix;
      Eigen::VectorXd right = equations.right;
      for (std::size_t k = 0; k < count; ++k) {
        const double ridge = prefers_few ? 0.5 * kRidge / (std::abs(parameters[k]) + 0.1) : kRidge;
        matrix(k, k) += ridge;
        right[k] -= ridge * parameters[k];
      }
      for (std::size_t k = 0; k < count; ++k) {
        if (!is_fixed[k]) continue;
        right -= matrix.col(k) * step[k];
        matrix.row(k).setZero();
        matrix.col(k).setZero();
        matrix(k, k) = 1;
      }
      for (std::size_t k = 0; k < count; ++k)
        if (is_fixed[k]) right[k] = step[k];
      step = matrix.ldlt().solve(right);
      bool has_left = false;
      for (std::size_t k = 0; k < count; ++k) {
        const double low = rig_.parameters[k].minimum - parameters[k],
                     high = 2 * rig_.parameters[k].maximum - parameters[k];
        if (is_fixed[k] || (step[k] >= low && step[k] <= high)) continue;
        step[k] = std::clamp(step[k], low, high);
        is_fixed[k] = has_left = true;
      }
      if (!has_left) break;
    }
    for (std::size_t k = 0; k < count; ++k) parameters[k] += step[k];
  }

  const ScanSurface& scan_;
  const Deformation& rig_;
  const NeutralSurface& neutral_;
  const std::vector<Eigen::Vector3i>& triangles_;
  const std::vector<bool>& skip_;
  const Eigen::Isometry3d& scan_from_neutral_;
  SampledFields fields_;
  Cascade cascade_;
  std::vector<double> areas_;
};

}  // namespace

MuscleGuess guess_muscles(const ScanSurface& scan, const Deformation& rig, const NeutralSurface& neutral,
                          const std::vector<Eigen::Vector3i>& triangles, const std::vector<bool>& skip,
                          const Eigen::Isometry3d& scan_from_neutral, StepKeeper* keeper) {
  const MuscleSearch search(scan, rig, neutral, triangles, skip, scan_from_neutral);
  std::optional<std::size_t> jaw;
  for (std::size_t k = 0; k < rig.parameters.size(); ++k)
    if (rig.parameters[k].name == kJaw) jaw = k;
  const auto search_from = [&](double start) {
    const std::string step = "muscles from " + std::to_string(start);
    const auto kept = keeper != nullptr ? keeper->find(step) : std::nullopt;
    if (kept && kept->size() == rig.parameters.size() + 1)
      return MuscleGuess{{kept->begin(), kept->end() - 1}, kept->back()};
    MuscleGuess guess = search.search(jaw, start);
    if (keeper != nullptr) {
      std::vector<double> numbers = guess.parameters;
      numbers.push_back(guess.cost);
      keeper->keep(step, numbers);
    }
    return guess;
  };
  MuscleGuess best = search_from(0);
  if (!jaw) return best;
  for (const double start : kJawStarts) {
    if (start == 0) continue;
    MuscleGuess other = search_from(start);
    if (other.cost < best.cost) best = std::move(other);
  }
  return best;
}

}  // namespace phiz
