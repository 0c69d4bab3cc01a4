#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

namespace phiz {

/// A band of sample rows with depth and the primitive seen at each sample.
struct SampleBand {
  static constexpr std::int32_t kNothing = -1;
  int width = 0, first_row = 0, rows = 0;
  std::vector<float> depth;         ///< larger is nearer; meaningless where nothing was drawn
  std::vector<std::int32_t> owner;  ///< triangle or point index, kNothing where empty

  void reset(int width_samples, int first, int row_count);
};

/// Draws where the sample's centre is covered and nearer than what is there; of equal depths the first stays.
/// Corners in samples (x right, y down, z nearer), |x| and |y| < kFarthest. Both windings are drawn.
inline constexpr float kFarthest = 16'777'216.0f;
void draw_triangle(const std::array<Eigen::Vector3f, 3>& corners, std::int32_t triangle_idx,
                   SampleBand& band);
/// Disc of constant depth.
void draw_disc(const Eigen::Vector3f& centre, float radius, std::int32_t point_idx, SampleBand& band);

/// Which primitives touch which band of `band_rows` sample rows, in order of index.
class BandBins {
 public:
  /// find_rows(i) gives the first and last row in samples touched by primitive i, or first > last for none.
  BandBins(int primitive_count, int row_count, int band_rows,
           const std::function<std::pair<int, int>(int)>& find_rows);
  int band_count() const { return static_cast<int>(starts_.size()) - 1; }
  std::span<const std::int32_t> primitives(int band) const;

 private:
  std::vector<std::size_t> starts_;
  std::vector<std::int32_t> primitives_;
};

}  // namespace phiz
