#include "stages/subdivide/quantise_target.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "stages/geometry/triangle_distance.h"

namespace phiz {
namespace {

std::vector<Eigen::Vector3f> to_float(std::span<const Eigen::Vector3d> positions) {
  std::vector<Eigen::Vector3f> rows;
  rows.reserve(positions.size());
  for (const Eigen::Vector3d& p : positions) rows.push_back(p.cast<float>());
  return rows;
}

Eigen::Vector3d centre_of(std::span<const Eigen::Vector3d> positions, const Eigen::Vector3i& t) {
  return (positions[t[0]] + positions[t[1]] + positions[t[2]]) / 3.0;
}

/// Vertices first, then a centre a triangle.
std::vector<Eigen::Vector3f> samples_of(std::span<const Eigen::Vector3d> positions,
                                        std::span<const Eigen::Vector3i> triangles) {
  std::vector<Eigen::Vector3f> samples = to_float(positions);
  samples.reserve(positions.size() + triangles.size());
  for (const Eigen::Vector3i& t : triangles) samples.push_back(centre_of(positions, t).cast<float>());
  return samples;
}

bool meets(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, const Eigen::Vector3d& a,
           const Eigen::Vector3d& u, const Eigen::Vector3d& v, double& met) {
  const Eigen::Vector3d p = direction.cross(v);
  const double det = u.dot(p);
  if (det == 0) return false;
  const Eigen::Vector3d from = origin - a, q = from.cross(u);
  const double first = from.dot(p) / det, second = direction.dot(q) / det;
  met = v.dot(q) / det;
  return first >= 0 && second >= 0 && first + second <= 1;
}

}  // namespace

QuantiseTarget::QuantiseTarget(std::span<const Eigen::Vector3d> positions,
                               std::span<const Eigen::Vector3i> triangles)
    : positions_(positions),
      triangles_(triangles),
      fan_offsets_(positions.size() + 1, 0),
      index_(to_float(positions), triangles) {
  for (const Eigen::Vector3i& t : triangles)
    for (const int v : t) ++fan_offsets_[v + 1];
  for (std::size_t v = 0; v < positions.size(); ++v) fan_offsets_[v + 1] += fan_offsets_[v];
  fan_triangles_.resize(fan_offsets_.back());
  std::vector<int> next(fan_offsets_.begin(), fan_offsets_.end() - 1);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const int v : triangles[t]) fan_triangles_[next[v]++] = static_cast<int>(t);
}

double QuantiseTarget::distance(const Eigen::Vector3d& point) const {
  const auto hit = index_.find_nearest(point, std::numeric_limits<double>::infinity());
  return hit ? hit->distance : std::numeric_limits<double>::infinity();
}

double QuantiseTarget::find_way(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                int vertex_idx) const {
  const double straight = (positions_[vertex_idx] - origin).dot(direction);
  double way = straight, best = std::numeric_limits<double>::infinity();
  for (const int triangle : fan(vertex_idx)) {
    const Eigen::Vector3i& t = triangles_[triangle];
    const Eigen::Vector3d& a = positions_[t[0]];
    double met = 0;
    if (meets(origin, direction, a, positions_[t[1]] - a, positions_[t[2]] - a, met) &&
        std::abs(met - straight) < best) {
      best = std::abs(met - straight);
      way = met;
    }
  }
  return way;
}

double QuantiseTarget::local_error(std::span<const Eigen::Vector3d> rounded, int vertex_idx) const {
  std::vector<int> around;  // triangles of the rounded surface that a sample here may be nearest to
  for (const int triangle : fan(vertex_idx))
    for (const int v : triangles_[triangle])
      for (const int other : fan(v)) around.push_back(other);
  std::sort(around.begin(), around.end());
  around.erase(std::unique(around.begin(), around.end()), around.end());
  const auto to_rounded = [&](const Eigen::Vector3d& sample) {
    double least = std::numeric_limits<double>::infinity();
    for (const int triangle : around) {
      const Eigen::Vector3i& t = triangles_[triangle];
      least = std::min(
          least,
          find_nearest_on_triangle(sample, rounded[t[0]], rounded[t[1]], rounded[t[2]]).squared_distance);
    }
    return std::sqrt(least);
  };
  double most = std::max(distance(rounded[vertex_idx]), to_rounded(positions_[vertex_idx]));
  for (const int triangle : fan(vertex_idx)) {
    const Eigen::Vector3i& t = triangles_[triangle];
    most = std::max({most, distance(centre_of(rounded, t)), to_rounded(centre_of(positions_, t))});
    for (const int v : t) most = std::max(most, to_rounded(positions_[v]));
  }
  return most;
}

HausdorffSamples measure_samples(const QuantiseTarget& target, std::span<const Eigen::Vector3d> rounded,
                                 std::span<const Eigen::Vector3i> triangles, double tolerance_mm) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  const SurfaceIndex rounded_index(to_float(rounded), triangles);
  const auto there = target.index().find_nearest(samples_of(rounded, triangles), kFar);
  const auto back = rounded_index.find_nearest(samples_of(target.positions(), triangles), kFar);
  HausdorffSamples samples;
  for (const auto* hits : {&there, &back}) {
    for (std::size_t i = 0; i < hits->size(); ++i) {
      const double distance = (*hits)[i].distance;
      samples.most_mm = std::max(samples.most_mm, distance);
      if (distance <= tolerance_mm || tolerance_mm <= 0) continue;
      if (i < rounded.size()) samples.vertices.push_back(static_cast<int>(i));
      const Eigen::Vector3i& near =
          i < rounded.size() ? triangles[(*hits)[i].triangle_idx] : triangles[i - rounded.size()];
      for (const int v : near) samples.vertices.push_back(v);
    }
  }
  std::sort(samples.vertices.begin(), samples.vertices.end());
  samples.vertices.erase(std::unique(samples.vertices.begin(), samples.vertices.end()),
                         samples.vertices.end());
  return samples;
}

}  // namespace phiz
