#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>

#include "stages/align/mesh_silhouette.h"
#include "stages/align/silhouette.h"

namespace phiz {

/// The reference: solid white triangles and points drawn by OSMesa without depth, read back. For pictures and
/// for the test that the exact scan conversion agrees; hundreds of times slower. One object a thread.
class OsmesaSilhouettes {
 public:
  /// Throws NumericalFailure if no context can be made.
  explicit OsmesaSilhouettes(int size);
  ~OsmesaSilhouettes();
  OsmesaSilhouettes(OsmesaSilhouettes&&) noexcept;
  OsmesaSilhouettes& operator=(OsmesaSilhouettes&&) noexcept;

  /// CONTRACT: frame.size is the size given to the constructor.
  Silhouette rasterise(std::span<const Eigen::Vector3f> positions, std::span<const Eigen::Vector3i> triangles,
                       const AffineMatrix& frame_from_model, ViewAxis axis, const SilhouetteFrame& frame);
  Silhouette rasterise_points(std::span<const Eigen::Vector3f> positions,
                              const AffineMatrix& frame_from_model, ViewAxis axis,
                              const SilhouetteFrame& frame, int size_px);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace phiz
