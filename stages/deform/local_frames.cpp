#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "stages/deform/deform.h"
#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

constexpr double kSigmaMm = 12;  ///< of the weights of surroundings
constexpr double kReach = 2.5;   ///< in sigmas
constexpr int kFewest = 8;       ///< so many vertices lie within a sigma at least

/// The rotation nearest to `covariance` (Kabsch), det +1.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& covariance) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace

LocalFrames::LocalFrames(const ControlMesh& generic_head) : positions_(generic_head.positions) {
  offsets_.push_back(0);
  std::vector<double> distances(positions_.size()), sorted;
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    for (std::size_t j = 0; j < positions_.size(); ++j) distances[j] = (positions_[j] - positions_[i]).norm();
    sorted = distances;
    const std::size_t few = std::min<std::size_t>(kFewest, sorted.size() - 1);
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(few), sorted.end());
    const double sigma = std::max(kSigmaMm, sorted[few]);  // wider where the mesh is coarse
    for (std::size_t j = 0; j < positions_.size(); ++j) {
      if (j == i || distances[j] > kReach * sigma) continue;
      neighbours_.push_back(static_cast<int>(j));
      weights_.push_back(std::exp(-0.5 * distances[j] * distances[j] / (sigma * sigma)));
    }
    offsets_.push_back(static_cast<int>(neighbours_.size()));
  }
}

std::vector<Eigen::Quaterniond> LocalFrames::compute(
    std::span<const Eigen::Vector3d> control_positions) const {
  if (control_positions.size() != positions_.size())
    throw InvalidInput("the subject's control mesh is not the generic head's");
  std::vector<Eigen::Quaterniond> frames(positions_.size());
  parallel_for(frames.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
      double sum = 0;
      for (int k = offsets_[i]; k < offsets_[i + 1]; ++k) {
        const int j = neighbours_[k];
        const Eigen::Vector3d from = positions_[j] - positions_[i];
        covariance += weights_[k] * (control_positions[j] - control_positions[i]) * from.transpose();
        sum += weights_[k] * from.squaredNorm();
      }
      // A little of the identity settles what surroundings in a line or none leave open.
      covariance += (0.001 * sum + 1e-9) * Eigen::Matrix3d::Identity();
      frames[i] = Eigen::Quaterniond(nearest_rotation(covariance));
      if (frames[i].w() < 0) frames[i].coeffs() *= -1;
    }
  });
  return frames;
}

}  // namespace phiz
