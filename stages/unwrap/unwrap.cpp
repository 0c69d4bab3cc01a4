#include "stages/unwrap/unwrap.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "stages/geometry/error.h"
#include "stages/geometry/normals.h"
#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

constexpr std::size_t kGrain = 4096;
constexpr int kFinestLevel = 8;

/// Columns: change of position along u and along v in a triangle.
Eigen::Matrix<double, 3, 2> slopes_in(const Eigen::Vector3i& t, const std::vector<Eigen::Vector2d>& uv,
                                      const std::vector<Eigen::Vector3d>& positions) {
  Eigen::Matrix2d plane;
  plane << uv[t[1]] - uv[t[0]], uv[t[2]] - uv[t[0]];
  Eigen::Matrix<double, 3, 2> space;
  space << positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]];
  return space * plane.inverse();
}

Eigen::Vector3d blend(const SurfacePoint& place, const Eigen::Vector3i& t,
                      const std::vector<Eigen::Vector3d>& values) {
  return place.weights[0] * values[t[0]] + place.weights[1] * values[t[1]] + place.weights[2] * values[t[2]];
}

}  // namespace

UvChart make_uv_chart(std::span<const Eigen::Vector2d> control_uv, std::span<const Eigen::Vector3i> triangles,
                      int level) {
  if (level < 0 || level > kFinestLevel) throw InvalidInput("level is not from 0 to 8");
  UvDomain domain(control_uv, triangles);
  SubdivisionHierarchy hierarchy(triangles, static_cast<int>(control_uv.size()), level);
  std::vector<Eigen::Vector2d> uv = evaluate_uv(hierarchy, control_uv, level);
  return {std::move(domain), std::move(hierarchy), std::move(uv), level};
}

UvSurface::UvSurface(const UvChart& chart, std::vector<Eigen::Vector3d> positions)
    : chart_(chart), positions_(std::move(positions)) {
  if (positions_.size() != chart.uv.size())
    throw InvalidInput("the surface has " + std::to_string(positions_.size()) + " vertices and the chart " +
                       std::to_string(chart.uv.size()));
  const std::vector<Eigen::Vector3i>& triangles = chart.hierarchy.triangles(chart.level);
  normals_ = compute_vertex_normals(positions_, triangles);
  slopes_u_.assign(positions_.size(), Eigen::Vector3d::Zero());
  for (const Eigen::Vector3i& t : triangles) {
    const Eigen::Vector2d b = chart.uv[t[1]] - chart.uv[t[0]], c = chart.uv[t[2]] - chart.uv[t[0]];
    const double area = b.x() * c.y() - b.y() * c.x();
    const Eigen::Vector3d slope = area * slopes_in(t, chart.uv, positions_).col(0);
    for (const int corner : t) slopes_u_[corner] += slope;  // averaged by area; only the direction counts
  }
  for (Eigen::Vector3d& slope : slopes_u_) slope.stableNormalize();
}

UvSample UvSurface::evaluate(const Eigen::Vector2d& uv) const {
  const SurfacePoint place = refine_place(chart_.domain.locate(uv), chart_.level);
  const Eigen::Vector3i& t = chart_.hierarchy.triangles(chart_.level)[place.triangle_idx];
  UvSample sample;
  sample.position = blend(place, t, positions_);
  const Eigen::Matrix<double, 3, 2> slopes = slopes_in(t, chart_.uv, positions_);
  sample.du = slopes.col(0);
  sample.dv = slopes.col(1);
  sample.normal = blend(place, t, normals_).stableNormalized();
  Eigen::Vector3d along = blend(place, t, slopes_u_);
  along -= sample.normal.dot(along) * sample.normal;
  sample.tangent = along.stableNormalized();
  sample.bitangent = sample.normal.cross(sample.tangent);
  return sample;
}

Eigen::Vector3d UvSurface::position_at(const Eigen::Vector2d& uv) const {
  const SurfacePoint place = refine_place(chart_.domain.locate(uv), chart_.level);
  return blend(place, chart_.hierarchy.triangles(chart_.level)[place.triangle_idx], positions_);
}

double UvSurface::interpolate(std::span<const std::uint8_t> values, const Eigen::Vector2d& uv) const {
  CONTRACT(values.size() == positions_.size());
  const SurfacePoint place = refine_place(chart_.domain.locate(uv), chart_.level);
  const Eigen::Vector3i& t = chart_.hierarchy.triangles(chart_.level)[place.triangle_idx];
  return place.weights[0] * values[t[0]] + place.weights[1] * values[t[1]] + place.weights[2] * values[t[2]];
}

GeometryImage make_geometry_image(const UvSurface& surface, std::span<const std::uint8_t> confidences,
                                  const PointCloud* cloud, const UnwrapOptions& options) {
  if (options.side < 2 || options.side > 8192)
    throw InvalidInput("a geometry image has 2 to 8192 nodes a side");
  GeometryImage image;
  image.width = image.height = options.side;
  const std::size_t count = image.node_count();
  image.positions.resize(count);
  image.normals.resize(count);
  if (!confidences.empty()) image.confidences.resize(count);
  parallel_for(count, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto side = static_cast<std::size_t>(options.side);
      const Eigen::Vector2d uv = image.uv(static_cast<int>(i % side), static_cast<int>(i / side));
      const UvSample sample = surface.evaluate(uv);
      image.positions[i] = sample.position.cast<float>();
      image.normals[i] = sample.normal.cast<float>();
      if (!confidences.empty())
        image.confidences[i] = static_cast<float>(surface.interpolate(confidences, uv) / 255);
    }
  });
  if (cloud && cloud->has_colours()) {
    BakedColours baked =
        bake_colours(*cloud, image.positions, image.normals, image.width, image.height, options.colours);
    image.colours = std::move(baked.colours);
    image.mask = std::move(baked.mask);
  }
  return image;
}

FloatImage bake_texture(const UvSurface& surface, const PointCloud& cloud, const UnwrapOptions& options) {
  const int side = options.side;
  if (side < 2 || side > 8192) throw InvalidInput("a texture has 2 to 8192 pixels a side");
  const std::size_t count = static_cast<std::size_t>(side) * side;
  std::vector<Eigen::Vector3f> positions(count), normals(count);
  parallel_for(count, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const double x = static_cast<double>(i % side), y = static_cast<double>(i / side);
      const UvSample sample = surface.evaluate({(x + 0.5) / side, 1 - (y + 0.5) / side});
      positions[i] = sample.position.cast<float>();
      normals[i] = sample.normal.cast<float>();
    }
  });
  const BakedColours baked = bake_colours(cloud, positions, normals, side, side, options.colours);
  FloatImage texture;
  texture.width = texture.height = side;
  const char* names[] = {"R", "G", "B"};
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<float>& channel = texture.channels[names[axis]];
    for (const Eigen::Vector3f& colour : baked.colours) channel.push_back(colour[axis]);
  }
  texture.channels["A"] = baked.mask;
  texture.attributes = {{"phizSchema", "phiz.texture.1"},
                        {"phizColour", "linear light, sRGB primaries"},
                        {"phizUv", "pixel (x,y) at u = (x+0.5)/width, v = 1 - (y+0.5)/height"}};
  return texture;
}

Image to_srgb(const FloatImage& texture) {
  Image picture;
  picture.width = texture.width;
  picture.height = texture.height;
  const auto &r = texture.channels.at("R"), &g = texture.channels.at("G"), &b = texture.channels.at("B");
  for (std::size_t i = 0; i < r.size(); ++i)
    picture.pixels.push_back({srgb_from_linear(r[i]), srgb_from_linear(g[i]), srgb_from_linear(b[i])});
  return picture;
}

}  // namespace phiz
