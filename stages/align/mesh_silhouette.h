#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "stages/align/contour_scan.h"
#include "stages/align/silhouette.h"

namespace phiz {

using AffineMatrix = Eigen::Matrix<double, 3, 4>;  ///< place = linear part * point + last column

/// A triangle mesh prepared for many silhouettes under changing transforms: coordinates apart, edges matched.
/// Any triangles will do: open, non-manifold and inconsistently oriented ones cost time, not correctness.
class SilhouetteMesh {
 public:
  /// Throws InvalidInput on an index out of range or a position that is not finite. O(F log F).
  SilhouetteMesh(std::span<const Eigen::Vector3f> positions, std::span<const Eigen::Vector3i> triangles);

  int vertex_count() const { return static_cast<int>(x_.size()); }
  int triangle_count() const { return static_cast<int>(triangles_.size()); }

 private:
  friend class SilhouetteRasteriser;
  struct InnerEdge {
    std::int32_t from, to;     ///< as `left` runs through it
    std::int32_t left, right;  ///< triangles
  };
  struct BorderEdge {
    std::int32_t from, to, triangle;
  };
  std::vector<double> x_, y_, z_;
  std::vector<std::array<std::int32_t, 3>> triangles_;
  std::vector<InnerEdge> inner_;
  std::vector<BorderEdge> border_;
};

/// Draws silhouettes by exact scan conversion in fixed point (8 bits below the pixel): a pixel is set when a
/// triangle covers its centre, centres on an edge by the top-left rule, as in GL. Only the outlines are
/// followed: the number of front-facing triangles over a pixel is the winding number of the border of the
/// front-facing part (likewise the back-facing), which costs the edges of the contours instead of all
/// triangles, and gives the very pixels that filling each triangle gives. Holds buffers: no allocation once
/// they have grown. One object a thread. Places are clamped to +-8192 pixels.
class SilhouetteRasteriser {
 public:
  /// `out` is resized if it has not the frame's size, cleared and drawn.
  void rasterise(const SilhouetteMesh& mesh, const AffineMatrix& frame_from_model, ViewAxis axis,
                 const SilhouetteFrame& frame, Silhouette& out);
  /// All three views at once, in the order of kViewAxes: cheaper than one by one, and the same pictures.
  void rasterise(const SilhouetteMesh& mesh, const AffineMatrix& frame_from_model,
                 const SilhouetteFrame& frame, std::array<Silhouette, 3>& out);

 private:
  void project(const SilhouetteMesh& mesh, const AffineMatrix& frame_from_model,
               const SilhouetteFrame& frame);
  void find_facing(const SilhouetteMesh& mesh);
  void collect_contours(const SilhouetteMesh& mesh, unsigned views);

  using Corner =
      std::array<std::int32_t, 3>;  ///< x right, y down, z right or down; fixed point, in the picture
  std::array<std::vector<std::int32_t>, 3> coordinates_;
  std::vector<Corner> corners_;
  std::vector<std::uint8_t> front_;  ///< bit k: the triangle has a positive area in view k
  std::array<ContourScan, 3> scans_;
};

}  // namespace phiz
