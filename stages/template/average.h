#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "formats/control_mesh.h"

namespace phiz {

struct AverageOptions {
  int smooth_rounds =
      20;  ///< of the change of shape over the mesh: lids and corners of the mouth are the head's
  double min_angle_deg = 15.2;  ///< vertices stay nearer to the head's where a triangle would be sharper
};

/// A generic head with the mean shape of subjects that were fitted with it: each is laid on the head (turned
/// and moved, not scaled) and averaged; the change is smoothed, for fits are less sure of details than of
/// proportions, and made mirror-symmetric; the neck loop keeps its distance from the plane
/// `neck`, triangles stay above the angle, and what crosses itself at level 4 is drawn apart. Connectivity,
/// (u,v), regions and landmarks are the head's; boxes follow the vertices in them. `subjects` hold one
/// position a vertex, mm. Throws InvalidInput: no subject, another number of vertices, a head without mirror
/// map. Deterministic.
ControlMesh average_heads(const ControlMesh& head, std::span<const std::vector<Eigen::Vector3d>> subjects,
                          const AverageOptions& options = {});

}  // namespace phiz
