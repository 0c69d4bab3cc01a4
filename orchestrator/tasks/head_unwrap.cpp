#include "orchestrator/tasks/head_unwrap.h"

#include <algorithm>
#include <sstream>

namespace phiz {
namespace {

HeadAsset parse(const std::string& bytes) {
  std::istringstream in(bytes);
  return read_head_asset(in);
}

}  // namespace

HeadUnwrap::HeadUnwrap(const std::string& asset_bytes) : HeadUnwrap(parse(asset_bytes)) {}

HeadUnwrap::HeadUnwrap(HeadAsset asset) : asset_(std::move(asset)) {
  const int level = std::max(0, static_cast<int>(asset_.displacements_mm.size()) - 1);
  std::vector<Eigen::Vector2d> uv;
  for (const Eigen::Vector2f& place : asset_.uv) uv.push_back(place.cast<double>());
  chart_ = std::make_unique<UvChart>(make_uv_chart(uv, asset_.triangles, level));
  std::vector<Eigen::Vector3d> control;
  for (const Eigen::Vector3f& position : asset_.positions) control.push_back(position.cast<double>());
  surface_ = std::make_unique<UvSurface>(
      *chart_, evaluate_surface(chart_->hierarchy, control, asset_.displacements_mm, level));
}

GeometryImage HeadUnwrap::geometry_image(const PointCloud* cloud, const UnwrapOptions& options) const {
  std::span<const std::uint8_t> confidences;
  if (!asset_.confidences.empty()) confidences = asset_.confidences.back();
  GeometryImage image = make_geometry_image(*surface_, confidences, cloud, options);
  image.template_digest = asset_.template_digest;
  return image;
}

}  // namespace phiz
