#pragma once

#include <Eigen/Core>
#include <span>

#include "stages/align/mesh_silhouette.h"
#include "stages/align/silhouette.h"

namespace phiz {

struct PointDrawing {
  int size_px = 1;           ///< side of the square drawn for each point; odd, [1, 63]
  bool shrink_back = false;  ///< afterwards take (size_px - 1) / 2 off the outline again, so that gaps stay
                             ///< closed and the outline lies where the points are
};

/// The square of size_px pixels around the pixel that holds each point, as GL draws points of odd size.
/// Points that are not finite or fall outside the picture are left out. O(N + size_px * words).
void rasterise_points(std::span<const Eigen::Vector3f> positions, const AffineMatrix& frame_from_model,
                      ViewAxis axis, const SilhouetteFrame& frame, const PointDrawing& drawing,
                      Silhouette& out);

struct PointSize {
  int pixels = 1;
  double pinhole_share = 0;  ///< of the covered pixels, at this size; the worst of the views
};

/// The smallest odd size up to max_size at which the silhouettes have no pinholes, that is, filling every
/// enclosed hole of at most (frame.size / 32)^2 pixels changes less than 0.1 % of the covered pixels. Larger
/// holes are taken for true ones. Where no size will do (outliers close loops with the outline as they grow),
/// the one with the smallest share. The points are drawn once, larger sizes grow from there. For one view, or
/// one size for all three.
PointSize find_point_size(std::span<const Eigen::Vector3f> positions, const AffineMatrix& frame_from_model,
                          ViewAxis axis, const SilhouetteFrame& frame, int max_size = 15);
PointSize find_point_size(std::span<const Eigen::Vector3f> positions, const AffineMatrix& frame_from_model,
                          const SilhouetteFrame& frame, int max_size = 15);

}  // namespace phiz
