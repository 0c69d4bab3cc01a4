#include "stages/align/silhouette.h"

#include <algorithm>
#include <cmath>

#include "stages/align/contour_scan.h"
#include "stages/geometry/error.h"

namespace phiz {
namespace {

struct PlaneAxes {
  int right, down;
  double down_sign;
};

PlaneAxes find_axes(ViewAxis axis) {
  switch (axis) {
    case ViewAxis::kFront:
      return {0, 1, -1.0};
    case ViewAxis::kSide:
      return {2, 1, -1.0};
    default:
      return {0, 2, 1.0};
  }
}

std::int32_t to_fixed(double pixels) {
  constexpr double kLimit = 8000;
  return static_cast<std::int32_t>(std::floor(std::clamp(pixels, -kLimit, kLimit) * ContourScan::kSub + 0.5));
}

constexpr std::uint64_t ones_from(int bit) {
  return ~std::uint64_t{0} << bit;
}
constexpr std::uint64_t ones_below(int bit) {
  return bit == 64 ? ~std::uint64_t{0} : ~ones_from(bit);
}

}  // namespace

Silhouette::Silhouette(int width, int height) : width_(width), height_(height) {
  CONTRACT(width % 64 == 0 && width >= 64 && width <= 4096 && height >= 1 && height <= 4096);
  words_.assign(static_cast<std::size_t>(words_per_row()) * height, 0);
}

void Silhouette::clear() {
  std::fill(words_.begin(), words_.end(), 0);
}

void Silhouette::fill_span(int y, int x_begin, int x_end) {
  if (x_begin >= x_end) return;
  std::uint64_t* const row_words = words_.data() + static_cast<std::size_t>(y) * words_per_row();
  const int first = x_begin / 64, last = (x_end - 1) / 64;
  const std::uint64_t head = ones_from(x_begin % 64), tail = ones_below((x_end - 1) % 64 + 1);
  if (first == last) {
    row_words[first] |= head & tail;
    return;
  }
  row_words[first] |= head;
  for (int k = first + 1; k < last; ++k) row_words[k] = ~std::uint64_t{0};
  row_words[last] |= tail;
}

Eigen::Vector2d SilhouetteFrame::project(const Eigen::Vector3d& place_mm, ViewAxis axis) const {
  const PlaneAxes axes = find_axes(axis);
  const Eigen::Vector3d from_centre = (place_mm - centre_mm) / mm_per_pixel;
  return {0.5 * size + from_centre[axes.right], 0.5 * size + axes.down_sign * from_centre[axes.down]};
}

SilhouetteFrame make_silhouette_frame(const Eigen::AlignedBox3d& box_mm, int size, double margin_share) {
  CONTRACT(!box_mm.isEmpty() && box_mm.sizes().allFinite() && box_mm.sizes().maxCoeff() > 0);
  SilhouetteFrame frame;
  frame.centre_mm = box_mm.center();
  frame.mm_per_pixel = box_mm.sizes().maxCoeff() * (1 + 2 * margin_share) / size;
  frame.size = size;
  return frame;
}

Silhouette make_polygon_mask(std::span<const Eigen::Vector2d> corners_px, int size) {
  Silhouette mask(size);
  ContourScan scan;
  scan.begin(size);
  for (std::size_t k = 0; k < corners_px.size(); ++k) {
    const Eigen::Vector2d& p = corners_px[k];
    const Eigen::Vector2d& q = corners_px[(k + 1) % corners_px.size()];
    scan.add_edge(to_fixed(p.x()), to_fixed(p.y()), to_fixed(q.x()), to_fixed(q.y()),
                  ContourScan::Counter::kFirst);
  }
  scan.fill(mask);
  return mask;
}

Silhouette make_half_plane_mask(const Eigen::Vector3d& normal, double offset_mm, ViewAxis axis,
                                const SilhouetteFrame& frame) {
  const PlaneAxes axes = find_axes(axis);
  const Eigen::Vector2d across(normal[axes.right], axes.down_sign * normal[axes.down]);
  Silhouette mask(frame.size);
  if (2 * across.squaredNorm() < normal.squaredNorm() || across.squaredNorm() == 0) {
    std::fill(mask.words().begin(), mask.words().end(), ~std::uint64_t{0});
    return mask;
  }
  // In pixels from the picture's centre: across . p >= reach.
  const double reach = (offset_mm - normal.dot(frame.centre_mm)) / (frame.mm_per_pixel * across.norm());
  const Eigen::Vector2d inwards = across.normalized(), along(-inwards.y(), inwards.x());
  const Eigen::Vector2d centre = Eigen::Vector2d::Constant(0.5 * frame.size);
  const double far = 2.0 * frame.size;
  const Eigen::Vector2d foot = centre + inwards * std::clamp(reach, -far, far);
  const std::array<Eigen::Vector2d, 4> corners = {foot - along * far, foot + along * far,
                                                  foot + along * far + inwards * 2 * far,
                                                  foot - along * far + inwards * 2 * far};
  return make_polygon_mask(corners, frame.size);
}

void intersect(Silhouette& a, const Silhouette& b) {
  CONTRACT(a.width() == b.width() && a.height() == b.height());
  for (std::size_t i = 0; i < a.words().size(); ++i) a.words()[i] &= b.words()[i];
}

}  // namespace phiz
