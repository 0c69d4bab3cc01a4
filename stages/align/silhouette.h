#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace phiz {

/// A binary picture, one bit a pixel. Row 0 is on top; pixel x of a row is bit x % 64 of word x / 64. Width
/// is a multiple of 64.
class Silhouette {
 public:
  Silhouette() = default;
  explicit Silhouette(int size) : Silhouette(size, size) {}
  Silhouette(int width, int height);  ///< all clear; CONTRACT on width % 64 == 0 and sizes in [64, 4096]

  int width() const { return width_; }
  int height() const { return height_; }
  int words_per_row() const { return width_ / 64; }
  bool empty() const { return words_.empty(); }
  std::span<std::uint64_t> row(int y) {
    return {words_.data() + static_cast<std::size_t>(y) * words_per_row(),
            static_cast<std::size_t>(words_per_row())};
  }
  std::span<const std::uint64_t> row(int y) const {
    return {words_.data() + static_cast<std::size_t>(y) * words_per_row(),
            static_cast<std::size_t>(words_per_row())};
  }
  std::span<std::uint64_t> words() { return words_; }
  std::span<const std::uint64_t> words() const { return words_; }

  bool covers(int x, int y) const { return row(y)[static_cast<std::size_t>(x) / 64] >> (x % 64) & 1; }
  void clear();
  void fill_span(int y, int x_begin, int x_end);  ///< sets [x_begin, x_end), which must lie in the picture
  bool operator==(const Silhouette&) const = default;

 private:
  int width_ = 0, height_ = 0;
  std::vector<std::uint64_t> words_;
};

/// Which axis one looks along, and what the picture shows.
enum class ViewAxis {
  kFront,  ///< x right, y up
  kSide,   ///< z right, y up
  kTop,    ///< x right, z down
};
inline constexpr std::array<ViewAxis, 3> kViewAxes = {ViewAxis::kFront, ViewAxis::kSide, ViewAxis::kTop};

/// Orthographic square pictures with square pixels around one place in space, the same scale in all views.
struct SilhouetteFrame {
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
  double mm_per_pixel = 1;
  int size = 256;  ///< pixels a side: 256 or 512; any multiple of 64 up to 4096

  /// Pixel coordinates (x right, y down; pixel centres at .5) of a place in mm.
  Eigen::Vector2d project(const Eigen::Vector3d& place_mm, ViewAxis axis) const;
};

/// The frame that shows the whole box with `margin_share` of its largest side left free on each side.
SilhouetteFrame make_silhouette_frame(const Eigen::AlignedBox3d& box_mm, int size,
                                      double margin_share = 0.08);

/// Pixels set. The same on every machine; uses the processor's own instruction where it has one.
std::int64_t count_pixels(const Silhouette& a);
/// Pixels that differ; with a mask only those set in the mask count. CONTRACT on equal sizes.
std::int64_t count_xor(const Silhouette& a, const Silhouette& b);
std::int64_t count_xor(const Silhouette& a, const Silhouette& b, const Silhouette& mask);

/// Every pixel of a simple or self-crossing polygon (corners in pixel coordinates of the picture, non-zero
/// winding).
Silhouette make_polygon_mask(std::span<const Eigen::Vector2d> corners_px, int size);
/// Pixels on the side of the plane where normal . place_mm >= offset_mm, for count_xor. A plane that faces
/// the viewer more than it is seen edge-on cannot clip this view: then all pixels are set. A slanted plane is
/// cut at the frame's centre.
Silhouette make_half_plane_mask(const Eigen::Vector3d& normal, double offset_mm, ViewAxis axis,
                                const SilhouetteFrame& frame);
/// a and b, in place.
void intersect(Silhouette& a, const Silhouette& b);

/// Sets every clear region of at most max_area pixels that does not touch the picture's edge (regions:
/// 4-connected). Returns how many pixels changed. O(words + runs).
std::int64_t fill_enclosed_holes(Silhouette& silhouette, std::int64_t max_area);
/// Clears every set region of less than min_area pixels (8-connected). Returns how many pixels changed.
std::int64_t remove_specks(Silhouette& silhouette, std::int64_t min_area);

/// Grows (radius > 0) or shrinks (radius < 0) by a square of 2 |radius| + 1 pixels. Outside the picture
/// counts as clear when growing and as set when shrinking.
void grow(Silhouette& silhouette, int radius);

}  // namespace phiz
