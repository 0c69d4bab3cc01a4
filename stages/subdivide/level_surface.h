#pragma once

#include <Eigen/Core>
#include <vector>

#include "stages/subdivide/subdivide.h"

namespace phiz {

/// The steps that evaluate_surface and displace share, so that both give the same bits.

/// From the positions of level-1 to the undisplaced ones of `level` >= 1: old vertices stay, new ones are
/// appended.
void refine_positions(const SubdivisionHierarchy& hierarchy, int level,
                      std::vector<Eigen::Vector3d>& positions);

/// First vertex of `level` that may be displaced there: 0 at level 0, then the first new one.
inline int first_displaced(const SubdivisionHierarchy& hierarchy, int level) {
  return level == 0 ? 0 : hierarchy.vertex_count(level - 1);
}

/// Unit angle-weighted normals of the vertices from first_displaced on, over the undisplaced positions of
/// `level`.
std::vector<Eigen::Vector3d> displacement_normals(const SubdivisionHierarchy& hierarchy, int level,
                                                  const std::vector<Eigen::Vector3d>& positions);

/// Moves the vertices from first_displaced on along their normals; displacements_mm as in HeadAsset.
void displace_along(const std::vector<Eigen::Vector3d>& normals, const std::vector<float>& displacements_mm,
                    std::vector<Eigen::Vector3d>& positions);

}  // namespace phiz
