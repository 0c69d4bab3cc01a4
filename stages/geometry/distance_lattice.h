#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace phiz {

/// Unsigned distance to a set of points on a dense lattice (exact Euclidean distance transform of the
/// occupied cells; Felzenszwalb and Huttenlocher 2012), read back by trilinear interpolation with its
/// gradient. Accurate to about half a cell. Build O(cells); a read is eight values.
class DistanceLattice {
 public:
  /// `cells_along` is the cell count of the longest side of the box that reaches `margin` beyond the points.
  DistanceLattice(std::span<const Eigen::Vector3f> points, float margin, int cells_along);

  struct Sample {
    float distance;
    Eigen::Vector3f gradient;
  };
  /// Outside the box the distance to the box is added. Unit: that of the points.
  Sample at(const Eigen::Vector3f& p) const;
  float cell() const { return cell_; }

 private:
  float cell_ = 1, inverse_cell_ = 1;
  Eigen::Vector3f origin_;
  Eigen::Vector3i dims_;
  std::vector<float> values_;
};

}  // namespace phiz
