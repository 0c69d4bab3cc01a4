#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "formats/control_mesh.h"

namespace phiz {

/// The (u,v) square as the generic head's triangles cut it: which triangle a place lies in, and where.
/// Copies what it needs; const calls from several threads are safe.
class UvDomain {
 public:
  /// Throws InvalidInput, naming the triangle, where (u,v) turn over or have no area, and where the triangles
  /// do not fill the unit square. O(F).
  UvDomain(std::span<const Eigen::Vector2d> uv, std::span<const Eigen::Vector3i> triangles);

  /// The triangle of the control mesh that holds (u,v), and the weights of its corners. Places beyond the
  /// square count as the nearest of its border. Weights are never negative, sum to 1 and are exactly 1 at a
  /// vertex and exactly 0 across an edge that holds the place; on edges and vertices the triangle with the
  /// smallest index answers. About 1 us.
  SurfacePoint locate(const Eigen::Vector2d& uv) const;

 private:
  Eigen::Vector3d weights_in(int triangle_idx, const Eigen::Vector2d& uv) const;

  std::vector<Eigen::Vector2d> uv_;
  std::vector<Eigen::Vector3i> triangles_;
  int cells_ = 1;  ///< a side of the search grid
  std::vector<int> cell_offsets_, cell_triangles_;
};

/// The same place in the triangles of `level` of a subdivision of the control mesh: triangle t becomes 4 t to
/// 4 t + 3, corners first (SubdivisionHierarchy). Exact but for doublings and one subtraction a level.
SurfacePoint refine_place(const SurfacePoint& control_place, int level);

}  // namespace phiz
