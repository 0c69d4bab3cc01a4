#include "stages/adapt/importance.h"

#include <algorithm>
#include <cmath>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "stages/geometry/point_index.h"

namespace phiz {
namespace {

constexpr float kLeast = 0.25f, kReach = 3.0f;

}  // namespace

std::vector<float> importance_of_confidence(std::span<const std::uint8_t> confidences) {
  std::vector<float> importance;
  for (const std::uint8_t c : confidences)
    importance.push_back(kLeast + (1 - kLeast) * static_cast<float>(c) / 255);
  return importance;
}

std::vector<float> importance_of_texture(const UvChart& chart, std::span<const Eigen::Vector3f> positions,
                                         const PointCloud& cloud) {
  if (!cloud.has_colours()) throw InvalidInput("the scan has no colours to weigh errors by");
  CONTRACT(positions.size() == chart.uv.size());
  const PointIndex index(cloud.positions);
  std::vector<float> light(positions.size(), -1.0f), contrast(positions.size(), 0.0f);
  parallel_for(positions.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const PointIndex::Neighbour nearest = index.find_nearest(positions[v], kReach);
      if (nearest.point_idx < 0) continue;
      const auto& colour = cloud.colours[nearest.point_idx];
      light[v] = (0.30f * static_cast<float>(colour[0]) + 0.59f * static_cast<float>(colour[1]) +
                  0.11f * static_cast<float>(colour[2])) /
                 255;
    }
  });
  for (const Eigen::Vector3i& t : chart.hierarchy.triangles(chart.level)) {
    for (int i = 0; i < 3; ++i) {
      const int a = t[i], b = t[(i + 1) % 3];
      if (light[a] < 0 || light[b] < 0) continue;
      const float gap = std::abs(light[a] - light[b]);
      contrast[a] = std::max(contrast[a], gap);
      contrast[b] = std::max(contrast[b], gap);
    }
  }
  std::vector<float> sorted = contrast;
  const auto high = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * 95 / 100);
  std::nth_element(sorted.begin(), high, sorted.end());
  const float full = std::max(*high, 1e-6f);
  for (float& value : contrast) value = kLeast + (1 - kLeast) * std::min(1.0f, value / full);
  return contrast;
}

}  // namespace phiz
