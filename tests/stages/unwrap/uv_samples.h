#pragma once

#include <Eigen/Core>
#include <vector>

namespace phiz::test {

/// A square cut into cells x cells x 2 triangles, inner places moved about at random (no triangle turns
/// over).
struct UvMesh {
  std::vector<Eigen::Vector2d> uv;
  std::vector<Eigen::Vector3i> triangles;
};
UvMesh random_uv_square(int cells);

/// Positions of a gently curved sheet over (u,v), outward towards +z.
std::vector<Eigen::Vector3d> curved_sheet(const std::vector<Eigen::Vector2d>& uv);

}  // namespace phiz::test
