#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace phiz {

/// Nearest point of a triangle surface.
struct SurfaceHit {
  int triangle_idx = -1;
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();  ///< barycentric, sum 1
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double distance = 0;  ///< unsigned for nearest point, along the ray for rays
};

/// Bounding volume hierarchy over triangles: nearest points and ray casts. Built and traversed in fixed order
/// with plain arithmetic, so that answers are the same bits on every machine; ties go to the smaller triangle
/// index. Build O(F log F); throws InvalidInput if an index is out of range or a corner is not finite.
/// Corners are copied. Queries are const and thread-safe. Closest point on a triangle: Ericson, Real-Time
/// Collision Detection (2005), 5.1.5. Ray-triangle: Möller and Trumbore (1997).
class SurfaceIndex {
 public:
  SurfaceIndex(std::span<const Eigen::Vector3f> positions, std::span<const Eigen::Vector3i> triangles);
  ~SurfaceIndex();
  SurfaceIndex(SurfaceIndex&&) noexcept;
  SurfaceIndex& operator=(SurfaceIndex&&) noexcept;

  /// Nearest surface point within max_distance (infinity is allowed); none if there is none or the query is
  /// not finite. Degenerate triangles count as segments.
  std::optional<SurfaceHit> find_nearest(const Eigen::Vector3d& query, double max_distance) const;
  /// First hit, from either side, of origin + t direction, t in (t_min, t_max]; direction need not be unit
  /// (distance is then t).
  std::optional<SurfaceHit> find_first_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                           double t_min, double t_max) const;
  /// Batch of find_nearest in parallel; a miss has triangle_idx -1. Queries are visited along a space-filling
  /// curve and answered in their own order.
  std::vector<SurfaceHit> find_nearest(std::span<const Eigen::Vector3f> queries, double max_distance) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace phiz
