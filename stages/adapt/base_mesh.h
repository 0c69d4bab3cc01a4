#pragma once

#include "formats/base_layout.h"
#include "stages/adapt/adaptive_mesh.h"
#include "stages/adapt/compliance.h"

namespace phiz {

/// Constrained Delaunay triangulation of the layout's points over the (u,v) square, its edges and the
/// square's sides kept. Corners counter-clockwise in (u,v), triangles in an order that the layout alone
/// decides. Throws InvalidInput that names points: the square's corners missing, two in one place, edges that
/// cross. Source: Goldenstein, Vogler, Velho 2005, 5.1; CGAL.
std::vector<Eigen::Vector3i> triangulate_layout(const BaseLayout& layout);

/// A base over (u,v) with its report: positions are for lengths (the surface there). Added vertices lie in
/// the middle of their parents.
struct MadeBase {
  BasePolyhedron polyhedron;
  CompliantMesh report;
};
MadeBase make_base(std::span<const Eigen::Vector2d> uv, std::span<const Eigen::Vector3i> triangles,
                   std::span<const Eigen::Vector3d> positions, BlockOrder order = BlockOrder::kMatching);

}  // namespace phiz
