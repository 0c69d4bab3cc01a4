#include "stages/align/point_silhouette.h"

#include <algorithm>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

constexpr double kPinholeShare = 0.001;

double find_share_of_view(Silhouette silhouette) {
  const std::int64_t side = silhouette.width() / 32;
  const std::int64_t covered = std::max<std::int64_t>(count_pixels(silhouette), 1);
  return static_cast<double>(fill_enclosed_holes(silhouette, side * side)) / static_cast<double>(covered);
}

double find_pinhole_share(std::span<const Silhouette> views) {
  double worst = 0;
  for (const Silhouette& view : views) worst = std::max(worst, find_share_of_view(view));
  return worst;
}

PointSize grow_until_closed(std::span<Silhouette> views, int max_size) {
  PointSize best{1, find_pinhole_share(views)};
  for (int pixels = 3; pixels <= max_size && best.pinhole_share >= kPinholeShare; pixels += 2) {
    for (Silhouette& view : views) grow(view, 1);
    const double share = find_pinhole_share(views);
    if (share < best.pinhole_share) best = {pixels, share};
  }
  return best;
}

}  // namespace

void rasterise_points(std::span<const Eigen::Vector3f> positions, const AffineMatrix& frame_from_model,
                      ViewAxis axis, const SilhouetteFrame& frame, const PointDrawing& drawing,
                      Silhouette& out) {
  CONTRACT(drawing.size_px % 2 == 1 && drawing.size_px >= 1 && drawing.size_px <= 63);
  if (out.width() != frame.size || out.height() != frame.size) out = Silhouette(frame.size);
  out.clear();
  const Eigen::Matrix3d linear = frame_from_model.leftCols<3>();
  const Eigen::Vector3d origin = frame_from_model.col(3);
  const double size = frame.size;
  for (const Eigen::Vector3f& p : positions) {
    const Eigen::Vector2d pixel = frame.project(linear * p.cast<double>() + origin, axis);
    if (!(pixel.x() >= 0 && pixel.x() < size && pixel.y() >= 0 && pixel.y() < size)) continue;
    const auto x = static_cast<std::size_t>(pixel.x());
    out.row(static_cast<int>(pixel.y()))[x / 64] |= std::uint64_t{1} << (x % 64);
  }
  grow(out, drawing.size_px / 2);
  if (drawing.shrink_back) grow(out, -(drawing.size_px / 2));
}

PointSize find_point_size(std::span<const Eigen::Vector3f> positions, const AffineMatrix& frame_from_model,
                          ViewAxis axis, const SilhouetteFrame& frame, int max_size) {
  std::array<Silhouette, 1> view;
  rasterise_points(positions, frame_from_model, axis, frame, {}, view[0]);
  return grow_until_closed(view, max_size);
}

PointSize find_point_size(std::span<const Eigen::Vector3f> positions, const AffineMatrix& frame_from_model,
                          const SilhouetteFrame& frame, int max_size) {
  std::array<Silhouette, 3> views;
  for (std::size_t k = 0; k < views.size(); ++k)
    rasterise_points(positions, frame_from_model, kViewAxes[k], frame, {}, views[k]);
  return grow_until_closed(views, max_size);
}

}  // namespace phiz
