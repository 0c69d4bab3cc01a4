#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace phiz {

/// Points sorted into the cells of a dense lattice: neighbourhoods of known radius without a tree.
/// `order[slot]` is the caller's index of the point in that slot; cells are x-fastest, slots of a cell keep
/// the caller's order, so visits are in a fixed order. Memory: 4 bytes a cell + 16 bytes a point. The lattice
/// is coarsened when it would exceed `max_cells`. O(N + cells).
class PointGrid {
 public:
  /// Points and the size of their box must be finite; cell > 0. An empty span gives a grid that finds
  /// nothing.
  PointGrid(std::span<const Eigen::Vector3f> points, float cell, std::size_t max_cells = 64'000'000);

  float cell() const { return cell_; }
  std::size_t size() const { return order_.size(); }
  const std::vector<int>& order() const { return order_; }
  const std::vector<Eigen::Vector3f>& sorted_points() const { return points_; }
  const Eigen::Vector3i& dimensions() const { return dims_; }
  const Eigen::Vector3f& origin() const { return origin_; }

  /// Lattice coordinates of a position; may lie outside [0, dimensions), at most a billion cells away.
  Eigen::Vector3i coordinates(const Eigen::Vector3f& p) const {
    return ((p - origin_) * inverse_cell_).array().floor().max(-1e9f).min(1e9f).cast<int>();
  }
  bool contains(const Eigen::Vector3i& c) const {
    return (c.array() >= 0).all() && (c.array() < dims_.array()).all();
  }
  std::size_t cell_index(const Eigen::Vector3i& c) const {
    return (static_cast<std::size_t>(c.z()) * dims_.y() + c.y()) * dims_.x() + c.x();
  }
  int cell_begin(std::size_t index) const { return starts_[index]; }
  int cell_end(std::size_t index) const { return starts_[index + 1]; }
  std::size_t cell_count() const { return starts_.size() - 1; }

  /// visit(slot, squared distance) for every point within `radius` of p.
  template <class Visit>
  void for_each_within(const Eigen::Vector3f& p, float radius, const Visit& visit) const {
    const Eigen::Vector3i low = coordinates(p - Eigen::Vector3f::Constant(radius)).cwiseMax(0);
    const Eigen::Vector3i high = coordinates(p + Eigen::Vector3f::Constant(radius)).cwiseMin(last_);
    if ((low.array() > high.array()).any()) return;
    const float squared_radius = radius * radius;
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        const std::size_t row = cell_index({0, y, z});
        const int end = starts_[row + high.x() + 1];
        for (int slot = starts_[row + low.x()]; slot < end; ++slot) {
          const float d2 = (points_[slot] - p).squaredNorm();
          if (d2 <= squared_radius) visit(slot, d2);
        }
      }
    }
  }

 private:
  float cell_ = 1, inverse_cell_ = 1;
  Eigen::Vector3f origin_ = Eigen::Vector3f::Zero();
  Eigen::Vector3i dims_ = Eigen::Vector3i::Zero();
  Eigen::Vector3i last_ = Eigen::Vector3i::Constant(-1);  ///< dims_ - 1
  std::vector<int> starts_, order_;
  std::vector<Eigen::Vector3f> points_;
};

}  // namespace phiz
