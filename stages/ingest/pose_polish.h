#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "formats/control_mesh.h"
#include "stages/ingest/pose_search.h"

namespace phiz {

/// Sharpens poses of `search_pose` and sorts them anew: iterated closest points, point to plane, where a
/// match must be near in place and in normal, so that brows, nose, lips and ears find their likes. The face
/// counts most. `scan` are all points in the scan's frame,
/// `spacing` apart (median_spacing); `score` becomes the mean truncated mismatch in
/// [0,1]. Normals of the scan are estimated at the scale of the first pose and used without sign.
/// Deterministic.
void polish_poses(std::span<const Eigen::Vector3f> scan, float spacing, const ControlMesh& generic_head,
                  std::vector<SimilarityPose>& poses);

}  // namespace phiz
