#include "stages/align/point_silhouette.h"

#include <utility>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

constexpr double kPinholeShare = 0.001;

// a and not b.
std::int64_t count_missing(const Silhouette& a, const Silhouette& b) {
  return count_xor(a, b, a);
}

PointSize find_size(Silhouette drawn) {
  if (count_pixels(drawn) == 0) return {};
  const int reach = drawn.width() / 64;
  Silhouette interior = drawn;
  grow(interior, reach);
  grow(interior, -2 * reach);
  const auto whole = static_cast<double>(count_pixels(interior));
  if (whole == 0) return {2 * reach + 1, 0};
  PointSize size{1, static_cast<double>(count_missing(interior, drawn)) / whole};
  while (size.pinhole_share >= kPinholeShare) {
    grow(drawn, 1);
    size = {size.pixels + 2, static_cast<double>(count_missing(interior, drawn)) / whole};
  }
  return size;
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
                          ViewAxis axis, const SilhouetteFrame& frame) {
  Silhouette drawn;
  rasterise_points(positions, frame_from_model, axis, frame, {}, drawn);
  return find_size(std::move(drawn));
}

PointSize find_point_size(std::span<const Eigen::Vector3f> positions, const AffineMatrix& frame_from_model,
                          const SilhouetteFrame& frame) {
  PointSize largest;
  for (const ViewAxis axis : kViewAxes) {
    const PointSize size = find_point_size(positions, frame_from_model, axis, frame);
    if (size.pixels > largest.pixels ||
        (size.pixels == largest.pixels && size.pinhole_share > largest.pinhole_share))
      largest = size;
  }
  return largest;
}

}  // namespace phiz
