#pragma once

#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

namespace phiz {

/// Pairs of triangles that cross without sharing a vertex, smaller index first, ascending. Exact up to
/// rounding of double arithmetic; touching does not count. O(F) for meshes of even triangles. Separating
/// interval on the common line: Möller (1997).
std::vector<std::pair<int, int>> find_self_intersections(std::span<const Eigen::Vector3d> positions,
                                                         std::span<const Eigen::Vector3i> triangles);

}  // namespace phiz
