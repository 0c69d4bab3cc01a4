#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace phiz {

/// Vertex normals weighted by angle (Baerentzen and Aanaes 2005); unit length, zero where no triangle has an area.
/// Deterministic at any thread count. O(F).
std::vector<Eigen::Vector3d> compute_vertex_normals(std::span<const Eigen::Vector3d> positions,
                                                    std::span<const Eigen::Vector3i> triangles);
std::vector<Eigen::Vector3f> compute_vertex_normals(std::span<const Eigen::Vector3f> positions,
                                                    std::span<const Eigen::Vector3i> triangles);

}  // namespace phiz
