#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "stages/geometry/half_edge.h"

namespace phiz {

/// Faces paired across edges: for each face the half-edge it is paired across; on the border that of a face
/// alone. -1: neither.
struct BlockMatching {
  std::vector<int> half_edge;
};

/// Along the edges by falling length, each whose faces are free.
BlockMatching match_longest_first(const HalfEdgeMesh& mesh, std::span<const Eigen::Vector3d> positions);

/// Pairs every face, by augmenting paths through blossoms; faces with a border edge may stay alone. Then
/// turns the pairs about vertices where that makes the paired edges longer in sum. Throws NumericalFailure
/// where a face stays alone inside (which a 2-manifold cannot make happen).
void complete_matching(const HalfEdgeMesh& mesh, std::span<const Eigen::Vector3d> positions,
                       BlockMatching& matching);

}  // namespace phiz
