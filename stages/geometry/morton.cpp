#include "stages/geometry/morton.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

namespace phiz {
namespace {

constexpr int kBitsPerAxis = 10;

struct Coded {
  std::uint32_t code;
  int idx;
};

/// Spreads the lowest 10 bits to every third bit.
std::uint32_t spread(std::uint32_t x) {
  x = (x | x << 16) & 0x030000FFu;
  x = (x | x << 8) & 0x0300F00Fu;
  x = (x | x << 4) & 0x030C30C3u;
  return (x | x << 2) & 0x09249249u;
}

/// One stable pass over the ten bits from `shift` on.
void sort_by_digit(const std::vector<Coded>& from, std::vector<Coded>& to, int shift) {
  constexpr std::uint32_t kMask = (1u << kBitsPerAxis) - 1;
  std::array<std::size_t, kMask + 2> starts{};
  for (const Coded& item : from) ++starts[(item.code >> shift & kMask) + 1];
  for (std::size_t digit = 1; digit < starts.size(); ++digit) starts[digit] += starts[digit - 1];
  for (const Coded& item : from) to[starts[item.code >> shift & kMask]++] = item;
}

}  // namespace

std::vector<int> morton_order(std::span<const Eigen::Vector3f> points) {
  Eigen::Array3f lower = Eigen::Array3f::Constant(std::numeric_limits<float>::max()), upper = -lower;
  for (const Eigen::Vector3f& point : points) {
    if (!point.allFinite()) continue;
    lower = lower.min(point.array());
    upper = upper.max(point.array());
  }
  const Eigen::Array3d size = upper.cast<double>() - lower.cast<double>();
  const Eigen::Array3d scale = (size > 0).select(((1 << kBitsPerAxis) - 1) / size, 0.0);

  std::vector<Coded> items(points.size()), scratch(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::uint32_t code = 0;
    if (points[i].allFinite()) {
      const Eigen::Array3d place = (points[i].array().cast<double>() - lower.cast<double>()) * scale;
      for (int axis = 0; axis < 3; ++axis) code |= spread(static_cast<std::uint32_t>(place[axis])) << axis;
    }
    items[i] = {code, static_cast<int>(i)};
  }
  for (int digit = 0; digit < 3; ++digit) {
    sort_by_digit(items, scratch, digit * kBitsPerAxis);
    items.swap(scratch);
  }
  std::vector<int> order(points.size());
  std::transform(items.begin(), items.end(), order.begin(), [](const Coded& item) { return item.idx; });
  return order;
}

}  // namespace phiz
