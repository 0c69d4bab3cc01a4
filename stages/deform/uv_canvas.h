#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "formats/control_mesh.h"

namespace phiz {

/// The generic head at the nodes of a grid over its (u,v) square: row 0 on top, side * side rows.
struct UvCanvas {
  int side = 0;
  std::vector<Eigen::Vector3d> positions;  ///< mm, of the smooth surface (level 3)
  std::vector<Eigen::Vector3d> normals;    ///< unit
  std::map<std::string, Eigen::Vector3d> landmarks;
  std::map<std::string, Eigen::Vector2d> landmark_uv;

  Eigen::Vector2d uv(int x, int y) const {
    return {static_cast<double>(x) / (side - 1), 1 - static_cast<double>(y) / (side - 1)};
  }
};

/// Throws InvalidInput where the square is not covered.
UvCanvas draw_uv_canvas(const ControlMesh& generic_head, int side);

/// A region of the annotations and what becomes of its border.
struct RegionEdge {
  std::string region;
  int shrink = 0;  ///< rings taken off
  int rings = 0;   ///< averages over one-rings
};

/// 1 in a region, 0 outside, its border averaged over one-rings, linear in
/// control triangles. Throws InvalidInput for regions the head does not have.
std::vector<double> draw_region(const ControlMesh& generic_head, int side, const RegionEdge& edge);

}  // namespace phiz
