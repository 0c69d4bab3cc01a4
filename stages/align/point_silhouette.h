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
  double pinhole_share =
      0;  ///< of the interior, what is still uncovered at this size; the worst of the views
};

/// The smallest odd size without pinholes. With R = frame.size / 64 pixels, the interior is what remains of
/// the points' pixels grown by R and then shrunk by 2 R: gaps up to 2 R wide are closed, true holes stay
/// open, the outline and scattered outliers are left out. A size has no pinholes if its squares leave less
/// than 0.1 % of the interior uncovered; 2 R + 1 always has none, and is the answer where the points are too
/// sparse to have an interior. For one view, or one size for all three.
PointSize find_point_size(std::span<const Eigen::Vector3f> positions, const AffineMatrix& frame_from_model,
                          ViewAxis axis, const SilhouetteFrame& frame);
PointSize find_point_size(std::span<const Eigen::Vector3f> positions, const AffineMatrix& frame_from_model,
                          const SilhouetteFrame& frame);

}  // namespace phiz
