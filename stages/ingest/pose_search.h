#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "formats/control_mesh.h"

namespace phiz {

/// p_scan = scale * rotation * p_model + translation.
struct SimilarityPose {
  double scale = 1;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  double score = 1;  ///< mean truncated distance / truncation over both directions, in [0,1]
};

/// Finds the generic head in a scan of unknown axes, unit and extent. `scan_points` are evenly thinned
/// samples (a few thousand) with no gross outliers, in any unit; there may be shoulders, a stand, a long
/// neck, missing parts. All rotations on a grid of about 25 degrees times five sizes are scored by truncated
/// distances, model to scan and scan to model (above the model's neck plane); the best are refined by
/// Gauss-Newton with a Geman-McClure weight. Returns the best poses, best first, no two within 15 degrees.
/// Deterministic. About 0.3 s.
std::vector<SimilarityPose> search_pose(std::span<const Eigen::Vector3f> scan_points,
                                        const ControlMesh& generic_head);

}  // namespace phiz
