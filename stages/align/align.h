#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "formats/control_mesh.h"
#include "formats/point_cloud.h"
#include "stages/align/silhouette.h"

namespace phiz {

struct AlignOptions {
  int coarse_size = 256, fine_size = 512;  ///< silhouette pixels of the two searches; multiples of 64
  double relative_tolerance = 1e-3;        ///< of Powell's method
  int max_evaluations = 3000;              ///< of each search
  /// Outlines alone hold a head's nod and size badly. The search pays this share of the covered pixels for
  /// each 3 degrees of turn, 6 % of stretch or 8 mm of shift away from the pose of `ingest`, squared. 0: the
  /// paper's count of white pixels alone.
  double pose_weight = 0.01;
  /// Leave out what lies behind the plane `back`; empty: where the scan has no back.
  std::optional<bool> clip_back;
};

struct AlignResult {
  Eigen::Matrix4d head_from_model =
      Eigen::Matrix4d::Identity();  ///< affine: rotation * scales along the model's axes, shift
  Eigen::Vector3d scales = Eigen::Vector3d::Ones();
  std::int64_t white_pixels_before = 0, white_pixels_after = 0;  ///< of the fine pictures, three views
  std::int64_t covered_pixels = 0;                               ///< of the cloud's fine pictures
  int evaluations = 0;
  bool clipped_back = false;
  int point_size_px = 1;
  SilhouetteFrame frame;                        ///< of the fine pictures
  std::array<Silhouette, 3> cloud_silhouettes;  ///< fine, by kViewAxes
  std::array<Silhouette, 3> model_silhouettes;
};

/// Silhouette alignment (Jeong et al. 2002, 4.1): the affine transform of the generic head (rotation,
/// translation, non-uniform scale) for which its three axis silhouettes differ least from the cloud's, by
/// Powell's method on the count of white pixels of their XOR, at two sizes. `cloud` is in the head frame, cut
/// at the neck; `head_scale` starts the search (both from `ingest`). The cloud's pictures are drawn once.
/// Pixels below the neck plane and, where the scan has no back, behind the back plane do not count.
/// Deterministic. About 0.2 s.
AlignResult align(const PointCloud& cloud, const ControlMesh& generic_head, double head_scale,
                  const AlignOptions& options = {});

}  // namespace phiz
