#include "stages/publish/raster.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace phiz {
namespace {

constexpr int kSubBits = 4;
constexpr std::int64_t kSub = 1 << kSubBits;

struct FixedPoint2 {
  std::int64_t x, y;
};

FixedPoint2 snap(const Eigen::Vector3f& p) {
  return {std::llrint(static_cast<double>(p.x()) * kSub), std::llrint(static_cast<double>(p.y()) * kSub)};
}

// Value of the edge from p to q at the centre of sample (0, 0) and its steps; > 0 on the inner side of a
// triangle that turns clockwise on the screen. Centres on an edge count for top and left edges only, so
// neighbours share no sample.
struct Edge {
  std::int64_t value, step_x, step_y;
  Edge(const FixedPoint2& p, const FixedPoint2& q) {
    const std::int64_t dx = q.x - p.x, dy = q.y - p.y;
    step_x = -dy * kSub;
    step_y = dx * kSub;
    value = dx * (kSub / 2 - p.y) - dy * (kSub / 2 - p.x);
    const bool top_or_left = dy < 0 || (dy == 0 && dx > 0);
    if (!top_or_left) value -= 1;
  }
  std::int64_t at(int x, int y) const { return value + step_x * x + step_y * y; }
};

int first_sample(std::int64_t fixed) {
  return static_cast<int>((fixed + kSub / 2 - 1) >> kSubBits);
}
int last_sample(std::int64_t fixed) {
  return static_cast<int>((fixed - kSub / 2) >> kSubBits);
}

struct DepthPlane {
  double value, step_x, step_y;
  float low, high;
};

DepthPlane make_depth_plane(const std::array<FixedPoint2, 3>& f, const std::array<float, 3>& z,
                            std::int64_t area) {
  const double scale = 1.0 / static_cast<double>(area);
  const double z1 = static_cast<double>(z[1]) - z[0], z2 = static_cast<double>(z[2]) - z[0];
  const double x1 = static_cast<double>(f[1].x - f[0].x), y1 = static_cast<double>(f[1].y - f[0].y);
  const double x2 = static_cast<double>(f[2].x - f[0].x), y2 = static_cast<double>(f[2].y - f[0].y);
  const double gx = (z1 * y2 - z2 * y1) * scale, gy = (z2 * x1 - z1 * x2) * scale;
  const double at_origin =
      z[0] + gx * static_cast<double>(kSub / 2 - f[0].x) + gy * static_cast<double>(kSub / 2 - f[0].y);
  return {at_origin, gx * kSub, gy * kSub, std::min({z[0], z[1], z[2]}), std::max({z[0], z[1], z[2]})};
}

}  // namespace

void SampleBand::reset(int width_samples, int first, int row_count) {
  width = width_samples;
  first_row = first;
  rows = row_count;
  depth.assign(static_cast<std::size_t>(width) * rows, 0.0f);
  owner.assign(static_cast<std::size_t>(width) * rows, kNothing);
}

void draw_triangle(const std::array<Eigen::Vector3f, 3>& corners, std::int32_t triangle_idx,
                   SampleBand& band) {
  std::array<FixedPoint2, 3> f = {snap(corners[0]), snap(corners[1]), snap(corners[2])};
  std::array<float, 3> z = {corners[0].z(), corners[1].z(), corners[2].z()};
  const auto [left, right] = std::minmax({f[0].x, f[1].x, f[2].x});
  const auto [top, bottom] = std::minmax({f[0].y, f[1].y, f[2].y});
  const int x0 = std::max(first_sample(left), 0), x1 = std::min(last_sample(right), band.width - 1);
  const int y0 = std::max(first_sample(top), band.first_row);
  const int y1 = std::min(last_sample(bottom), band.first_row + band.rows - 1);
  if (x0 > x1 || y0 > y1) return;
  std::int64_t area = (f[1].x - f[0].x) * (f[2].y - f[0].y) - (f[1].y - f[0].y) * (f[2].x - f[0].x);
  if (area == 0) return;
  if (area < 0) {
    std::swap(f[1], f[2]);
    std::swap(z[1], z[2]);
    area = -area;
  }
  const std::array<Edge, 3> edges = {Edge(f[0], f[1]), Edge(f[1], f[2]), Edge(f[2], f[0])};
  const DepthPlane plane = make_depth_plane(f, z, area);
  for (int y = y0; y <= y1; ++y) {
    std::array<std::int64_t, 3> e = {edges[0].at(x0, y), edges[1].at(x0, y), edges[2].at(x0, y)};
    const std::size_t row = static_cast<std::size_t>(y - band.first_row) * band.width;
    for (int x = x0; x <= x1; ++x) {
      if ((e[0] | e[1] | e[2]) >= 0) {
        const double exact = plane.value + plane.step_x * x + plane.step_y * y;
        const float depth = std::clamp(static_cast<float>(exact), plane.low, plane.high);
        if (band.owner[row + x] == SampleBand::kNothing || depth > band.depth[row + x]) {
          band.depth[row + x] = depth;
          band.owner[row + x] = triangle_idx;
        }
      }
      for (int k = 0; k < 3; ++k) e[k] += edges[k].step_x;
    }
  }
}

void draw_disc(const Eigen::Vector3f& centre, float radius, std::int32_t point_idx, SampleBand& band) {
  const int y0 = std::max(static_cast<int>(std::ceil(centre.y() - radius - 0.5f)), band.first_row);
  const int y1 =
      std::min(static_cast<int>(std::floor(centre.y() + radius - 0.5f)), band.first_row + band.rows - 1);
  for (int y = y0; y <= y1; ++y) {
    const float dy = static_cast<float>(y) + 0.5f - centre.y();
    const float half = std::sqrt(std::max(radius * radius - dy * dy, 0.0f));
    const int x0 = std::max(static_cast<int>(std::ceil(centre.x() - half - 0.5f)), 0);
    const int x1 = std::min(static_cast<int>(std::floor(centre.x() + half - 0.5f)), band.width - 1);
    const std::size_t row = static_cast<std::size_t>(y - band.first_row) * band.width;
    for (int x = x0; x <= x1; ++x) {
      if (band.owner[row + x] != SampleBand::kNothing && centre.z() <= band.depth[row + x]) continue;
      band.depth[row + x] = centre.z();
      band.owner[row + x] = point_idx;
    }
  }
}

BandBins::BandBins(int primitive_count, int row_count, int band_rows,
                   const std::function<std::pair<int, int>(int)>& find_rows) {
  const int bands = (row_count + band_rows - 1) / band_rows;
  std::vector<std::pair<std::int32_t, std::int32_t>> ranges(primitive_count);
  starts_.assign(static_cast<std::size_t>(bands) + 1, 0);
  for (int i = 0; i < primitive_count; ++i) {
    const auto [first, last] = find_rows(i);
    const int low = std::max(first, 0) / band_rows,
              high = last < 0 ? -1 : std::min(last / band_rows, bands - 1);
    ranges[i] = {low, first > last ? -1 : high};
    for (int band = low; band <= ranges[i].second; ++band) ++starts_[static_cast<std::size_t>(band) + 1];
  }
  for (int band = 0; band < bands; ++band) starts_[static_cast<std::size_t>(band) + 1] += starts_[band];
  primitives_.resize(starts_.back());
  std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
  for (int i = 0; i < primitive_count; ++i)
    for (int band = ranges[i].first; band <= ranges[i].second; ++band) primitives_[next[band]++] = i;
}

std::span<const std::int32_t> BandBins::primitives(int band) const {
  return std::span(primitives_)
      .subspan(starts_[band], starts_[static_cast<std::size_t>(band) + 1] - starts_[band]);
}

}  // namespace phiz
