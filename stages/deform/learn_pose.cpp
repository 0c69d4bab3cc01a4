#include "stages/deform/learn_pose.h"

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <cmath>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

constexpr double kReachesMm[] = {15, 10, 8, 6, 5, 4, 3, 3, 2, 2, 1.5, 1.5, 1.5, 1, 1, 1, 1, 1, 1, 1};
constexpr double kMeasureBelowMm = 1.6;  ///< nearer than this the scan is measured along the normal
constexpr double kRobustShare = 0.35;    ///< of the reach: scale of the weights
constexpr double kRimBorder = 0.8;
constexpr int kFewest = 100;

/// Distance from a place to the scan along `normal`, and its weight; 0 where there is no match.
struct PlaneMatch {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double offset_mm = 0, weight = 0;
};

PlaneMatch match(const ScanSurface& scan, const Eigen::Vector3d& position, const Eigen::Vector3d& normal,
                 double reach_mm) {
  PlaneMatch found;
  double confidence = 0;
  if (reach_mm > kMeasureBelowMm) {
    const auto nearest =
        scan.find_match(position.cast<float>(), normal.cast<float>(), 10.0f, static_cast<float>(reach_mm));
    if (nearest.surfel_idx < 0) return {};
    const Surfel& surfel = scan.surfels()[nearest.surfel_idx];
    if (surfel.border > kRimBorder) return {};
    found.normal = surfel.normal.cast<double>();
    found.offset_mm = found.normal.dot(surfel.position.cast<double>() - position);
    confidence = surfel.confidence;
  } else {
    const auto measured =
        scan.measure(position.cast<float>(), normal.cast<float>(), 1.5f, static_cast<float>(2 * reach_mm));
    if (measured.confidence <= 0) return {};
    found.normal = normal;
    found.offset_mm = measured.offset_mm;
    confidence = measured.confidence;
  }
  const double relative = found.offset_mm / (kRobustShare * reach_mm);
  found.weight = confidence / std::pow(1 + relative * relative, 2);
  return found;
}

struct NormalEquations {
  Eigen::Matrix<double, 6, 6> matrix = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
  int count = 0;
  NormalEquations& operator+=(const NormalEquations& other) {
    matrix += other.matrix;
    right += other.right;
    count += other.count;
    return *this;
  }
};

Eigen::Matrix3d turn_by(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  if (angle == 0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

}  // namespace

Eigen::Isometry3d find_rigid_motion(const ScanSurface& scan, const StillPlaces& places,
                                    const Eigen::Isometry3d& start) {
  CONTRACT(places.positions.size() == places.normals.size() &&
           places.positions.size() == places.weights.size());
  Eigen::Isometry3d motion = start;
  for (const double reach_mm : kReachesMm) {
    const NormalEquations sum = parallel_sum(
        places.positions.size(), 512, NormalEquations{}, [&](std::size_t begin, std::size_t end) {
          NormalEquations part;
          for (std::size_t i = begin; i < end; ++i) {
            if (!(places.weights[i] > 0)) continue;
            const Eigen::Vector3d position = motion * places.positions[i];
            const PlaneMatch found = match(scan, position, motion.linear() * places.normals[i], reach_mm);
            if (found.weight <= 0) continue;
            Eigen::Matrix<double, 6, 1> row;
            row << position.cross(found.normal), found.normal;
            const double weight = places.weights[i] * found.weight;
            part.matrix += weight * row * row.transpose();
            part.right += weight * found.offset_mm * row;
            ++part.count;
          }
          return part;
        });
    if (sum.count < kFewest)
      throw InvalidInput("the expression scan shows too little of what stays still: " +
                         std::to_string(sum.count) + " places found it");
    const Eigen::Matrix<double, 6, 1> step = sum.matrix.ldlt().solve(sum.right);
    if (!step.allFinite()) throw NumericalFailure("the head's motion between the takes cannot be found");
    Eigen::Isometry3d by = Eigen::Isometry3d::Identity();
    by.linear() = turn_by(step.head<3>());
    by.translation() = step.tail<3>();
    motion = by * motion;
  }
  motion.linear() = Eigen::Quaterniond(motion.linear()).normalized().toRotationMatrix();
  return motion;
}

Eigen::Isometry3d find_common_motion(const std::vector<Eigen::Vector3d>& from,
                                     const std::vector<Eigen::Vector3d>& to,
                                     const std::vector<double>& weights) {
  CONTRACT(from.size() == to.size() && from.size() == weights.size());
  constexpr double kScalesMm[] = {4, 2, 1, 0.6, 0.4, 0.3, 0.3, 0.3, 0.3, 0.3};
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  for (const double scale : kScalesMm) {
    std::vector<double> w(from.size());
    double sum = 0;
    Eigen::Vector3d from_mean = Eigen::Vector3d::Zero(), to_mean = from_mean;
    for (std::size_t i = 0; i < from.size(); ++i) {
      const double relative = (motion * from[i] - to[i]).norm() / scale;
      w[i] = weights[i] / std::pow(1 + relative * relative, 2);
      sum += w[i];
      from_mean += w[i] * from[i];
      to_mean += w[i] * to[i];
    }
    if (!(sum > 0)) return motion;
    from_mean /= sum;
    to_mean /= sum;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < from.size(); ++i)
      covariance += w[i] * (to[i] - to_mean) * (from[i] - from_mean).transpose();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const bool flips = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0;
    const Eigen::Vector3d signs(1, 1, flips ? -1 : 1);
    motion.linear() = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
    motion.translation() = to_mean - motion.linear() * from_mean;
  }
  return motion;
}

}  // namespace phiz
