#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

namespace phiz {

/// k-d tree over points (nanoflann). Ties in distance go to the smaller index, so answers are deterministic.
/// Build O(N log N), 16 bytes a point besides the tree; points are copied. Throws InvalidInput if one is not
/// finite. A query that is not finite finds nothing. Queries are const and thread-safe.
class PointIndex {
 public:
  explicit PointIndex(std::span<const Eigen::Vector3f> points);
  ~PointIndex();
  PointIndex(PointIndex&&) noexcept;
  PointIndex& operator=(PointIndex&&) noexcept;

  struct Neighbour {
    int point_idx = -1;
    float squared_distance = 0;
  };

  /// The k nearest, nearest first; fewer if there are fewer points. `out` is cleared.
  void find_nearest(const Eigen::Vector3f& query, int k, std::vector<Neighbour>& out) const;
  /// The nearest one within max_distance, or point_idx -1.
  Neighbour find_nearest(const Eigen::Vector3f& query, float max_distance) const;
  /// All within radius, in order of index. `out` is cleared.
  void find_within(const Eigen::Vector3f& query, float radius, std::vector<Neighbour>& out) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace phiz
