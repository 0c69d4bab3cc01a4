#pragma once

#include <Eigen/Core>
#include <span>

#include "stages/subdivide/subdivide.h"

namespace phiz {

/// Angle-weighted unit normals at the centres of rings: `centres[i]` lies amid the positions named by
/// `rings[i]`. The same sums as compute_vertex_normals, with the fan's triangles taken in ring order. Vector
/// code.
void compute_ring_normals(std::span<const Eigen::Vector3d> positions,
                          std::span<const Eigen::Vector3d> centres,
                          std::span<const SubdivisionHierarchy::Ring> rings,
                          std::span<Eigen::Vector3d> normals);

}  // namespace phiz
