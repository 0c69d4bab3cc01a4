#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "stages/template/layout.h"

namespace phiz {

/// A piece of a spline in space that a vertex may slide along: Catmull-Rom from points[1] to points[2].
struct Rail {
  std::array<Eigen::Vector3d, 4> points;
  double parameter = 0.5;
  Eigen::Vector3d at(double t) const;
};

/// Triangles over points of the half square, with what is known of its edges and vertices.
struct HalfMesh {
  struct Vertex {
    Eigen::Vector2d uv = Eigen::Vector2d::Zero();
    bool held = false;         ///< stays where it is
    std::optional<Rail> rail;  ///< slides along a curve
    bool on_mirror() const { return uv[0] == 0.5; }
    bool on_neck() const { return uv[0] == 0 || uv[1] == 0 || uv[1] == 1; }
  };
  std::vector<Vertex> vertices;
  std::vector<Eigen::Vector3i> triangles;          ///< counter-clockwise in (u,v)
  std::map<std::pair<int, int>, int> curve_edges;  ///< (smaller, larger vertex) -> index in Layout::curves,
                                                   ///< -1 for an `edge`
};

/// Constrained Delaunay triangulation (CGAL) of a layout's points with its curves and the half square's
/// border as constraints. Throws InvalidInput, with the names: curves that cross, a curve through a point
/// that is not its own, corners of the square without a point.
HalfMesh triangulate_layout(const Layout& layout);

}  // namespace phiz
