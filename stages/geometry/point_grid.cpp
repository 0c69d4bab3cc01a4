#include "stages/geometry/point_grid.h"

#include "stages/geometry/error.h"

namespace phiz {

PointGrid::PointGrid(std::span<const Eigen::Vector3f> points, float cell, std::size_t max_cells)
    : cell_(cell) {
  CONTRACT(cell > 0);
  if (points.empty()) {
    starts_.assign(1, 0);
    return;
  }
  Eigen::Array3f low = points[0], high = points[0];
  for (const auto& p : points) {
    low = low.min(p.array());
    high = high.max(p.array());
  }
  CONTRACT((high - low).isFinite().all());
  origin_ = low;
  for (;; cell_ *= 1.26f) {
    inverse_cell_ = 1.0f / cell_;
    if ((((high - low) * inverse_cell_).cast<double>().floor() + 1.0).prod() > static_cast<double>(max_cells))
      continue;
    last_ = coordinates(high);  // the expression that sorts and finds points: none lies beyond the last cell
    dims_ = last_ + Eigen::Vector3i::Ones();
    break;
  }

  const std::size_t count = points.size();
  std::vector<std::uint32_t> cell_of(count);
  starts_.assign(static_cast<std::size_t>(dims_.x()) * dims_.y() * dims_.z() + 1, 0);
  for (std::size_t i = 0; i < count; ++i) {
    cell_of[i] = static_cast<std::uint32_t>(cell_index(coordinates(points[i])));
    ++starts_[cell_of[i] + 1];
  }
  for (std::size_t c = 1; c < starts_.size(); ++c) starts_[c] += starts_[c - 1];
  order_.resize(count);
  points_.resize(count);
  std::vector<int> next(starts_.begin(), starts_.end() - 1);
  for (std::size_t i = 0; i < count; ++i) {
    const int slot = next[cell_of[i]]++;
    order_[slot] = static_cast<int>(i);
    points_[slot] = points[i];
  }
}

}  // namespace phiz
