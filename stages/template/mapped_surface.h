#pragma once

#include <Eigen/Core>
#include <vector>

#include "formats/control_mesh.h"

namespace phiz {

/// Half of a symmetric head (x <= 0) with its map to the right half (u <= 1/2) of the square, one-to-one. The
/// neck loop lies on u = 0, v = 0 (throat) and v = 1 (nape), the mirror line on u = 1/2.
struct MappedSurface {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Vector3i> triangles;
  std::vector<Eigen::Vector2d> uv;
};

/// Finds the place on the surface of a point of the half square. Const and thread-safe; O(1) on the average.
class SurfaceLookup {
 public:
  explicit SurfaceLookup(const MappedSurface& surface);

  struct Place {
    int triangle_idx = -1;
    Eigen::Vector3d weights = Eigen::Vector3d::Zero();  ///< clamped to the triangle
  };
  /// Points outside the half square go to the nearest triangle of their cell's surroundings.
  Place find(const Eigen::Vector2d& uv) const;

  Eigen::Vector3d position(const Place& place) const;
  Eigen::Vector3d normal(const Place& place) const;  ///< interpolated from vertex normals; unit
  Eigen::Vector3d position(const Eigen::Vector2d& uv) const { return position(find(uv)); }
  /// The place nearest to `target` that a descent from `uv` finds; it stays inside the half square, and on
  /// the mirror line if it starts there.
  Eigen::Vector2d descend_to(const Eigen::Vector3d& target, Eigen::Vector2d uv) const;
  /// d(position)/d(u,v) of the triangle there.
  Eigen::Matrix<double, 3, 2> jacobian(const Place& place) const;

 private:
  const MappedSurface& surface_;
  std::vector<Eigen::Vector3d> normals_;
  int cells_u_ = 1, cells_v_ = 1;
  std::vector<std::vector<int>> cells_;
};

}  // namespace phiz
