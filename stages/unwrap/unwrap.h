#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "formats/geometry_image.h"
#include "formats/image.h"
#include "formats/point_cloud.h"
#include "stages/subdivide/subdivide.h"
#include "stages/unwrap/uv_domain.h"

namespace phiz {

/// What the generic head alone decides about its (u,v) square; made once for all subjects.
struct UvChart {
  UvDomain domain;
  SubdivisionHierarchy hierarchy;
  std::vector<Eigen::Vector2d> uv;  ///< of the vertices of `level`
  int level = 0;
};

/// level 0 .. 8. Throws InvalidInput as UvDomain and SubdivisionHierarchy do.
UvChart make_uv_chart(std::span<const Eigen::Vector2d> control_uv, std::span<const Eigen::Vector3i> triangles,
                      int level);

/// A subject's surface at one (u,v).
struct UvSample {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();     ///< mm
  Eigen::Vector3d du = Eigen::Vector3d::Zero(), dv = du;  ///< slopes of the surface there, mm a unit of u, v
  Eigen::Vector3d normal = du, tangent = du, bitangent = du;  ///< right-handed, unit, continuous in (u,v)
};

/// A subject's displaced surface as a function of (u,v): linear in the triangles of the chart's level, whose
/// (u,v) follow the hierarchy, so that it meets every vertex exactly. Position, du and dv are those of the
/// triangles; the frame comes from slopes and normals averaged at the vertices and is continuous: the tangent
/// is the averaged du made square to the normal. Keeps a reference to the chart. Const calls from several
/// threads are safe.
class UvSurface {
 public:
  /// `positions` of the chart's level, as evaluate_surface gives them. Throws InvalidInput where their number
  /// differs.
  UvSurface(const UvChart& chart, std::vector<Eigen::Vector3d> positions);
  UvSample evaluate(const Eigen::Vector2d& uv) const;
  Eigen::Vector3d position_at(const Eigen::Vector2d& uv) const;
  /// A value a vertex of the level, linear in the triangles.
  double interpolate(std::span<const std::uint8_t> values, const Eigen::Vector2d& uv) const;

  const UvChart& chart() const { return chart_; }
  const std::vector<Eigen::Vector3d>& positions() const { return positions_; }
  const std::vector<Eigen::Vector3d>& normals() const { return normals_; }

 private:
  const UvChart& chart_;
  std::vector<Eigen::Vector3d> positions_, normals_, slopes_u_;  ///< slopes averaged at the vertices
};

struct ColourOptions {
  double reach_mm = 2.5;   ///< points farther away give no colour
  double spread_mm = 0.5;  ///< sigma of the weights
};

/// Colours of places on the surface, linear light, from the scan's points about them (Gaussian weights, those
/// whose normals agree count more).
struct BakedColours {
  std::vector<Eigen::Vector3f> colours;
  std::vector<float> mask;  ///< 1 seen, 0 filled in from the surroundings
};

/// `width` x `height` places in rows. What no point saw is filled in by pushing and pulling through a pyramid
/// of the rows. Throws InvalidInput for a cloud without colours or normals. Deterministic. 0.3 s for 512 x
/// 512.
BakedColours bake_colours(const PointCloud& cloud, std::span<const Eigen::Vector3f> positions,
                          std::span<const Eigen::Vector3f> normals, int width, int height,
                          const ColourOptions& options = {});

struct UnwrapOptions {
  int side = 512;  ///< nodes a side, 2 .. 8192
  ColourOptions colours;
};

/// The surface at the nodes of a grid: position, normal, confidence (a byte a vertex of the level, 255 = 1;
/// may be empty) and, where the cloud has colours, colour and mask. `cloud` may be null. Deterministic at any
/// thread count. 0.2 s for 512 x 512 without colours.
GeometryImage make_geometry_image(const UvSurface& surface, std::span<const std::uint8_t> confidences,
                                  const PointCloud* cloud, const UnwrapOptions& options = {});

/// A colour map as renderers read it: at pixel centres, u = (x + 0.5) / side, v = 1 - (y + 0.5) / side; R, G,
/// B in linear light and A = mask.
FloatImage bake_texture(const UvSurface& surface, const PointCloud& cloud, const UnwrapOptions& options = {});
/// R, G and B of such a map as 8-bit sRGB.
Image to_srgb(const FloatImage& texture);

}  // namespace phiz
