#include "stages/deform/uv_canvas.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "stages/deform/deform.h"
#include "stages/geometry/error.h"
#include "stages/geometry/normals.h"

namespace phiz {
namespace {

constexpr int kLevel = 3;

/// Calls paint(node, triangle, weights) for every node that a triangle covers, borders included; where
/// several do, the first one paints.
template <typename Paint>
std::size_t rasterise(const std::vector<Eigen::Vector3i>& triangles, const std::vector<Eigen::Vector2d>& uv,
                      int side, const Paint& paint) {
  std::vector<bool> done(static_cast<std::size_t>(side) * side, false);
  std::size_t painted = 0;
  constexpr double kSlack = 1e-6;  // of a weight: nodes on an edge belong to one of its triangles
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    std::array<Eigen::Vector2d, 3> corners;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector2d& place = uv[triangles[t][i]];
      corners[i] = {place.x() * (side - 1), (1 - place.y()) * (side - 1)};
    }
    const Eigen::Vector2d a = corners[1] - corners[0], b = corners[2] - corners[0];
    const double area = a.x() * b.y() - a.y() * b.x();
    if (area == 0) continue;
    const auto low = [&](int c) {
      return std::max(
          0, static_cast<int>(std::ceil(std::min({corners[0][c], corners[1][c], corners[2][c]}) - 1e-6)));
    };
    const auto high = [&](int c) {
      return std::min(
          side - 1,
          static_cast<int>(std::floor(std::max({corners[0][c], corners[1][c], corners[2][c]}) + 1e-6)));
    };
    for (int y = low(1); y <= high(1); ++y) {
      for (int x = low(0); x <= high(0); ++x) {
        const Eigen::Vector2d p = Eigen::Vector2d(x, y) - corners[0];
        const double v = (p.x() * b.y() - p.y() * b.x()) / area, w = (a.x() * p.y() - a.y() * p.x()) / area;
        const std::size_t node = static_cast<std::size_t>(y) * side + x;
        if (done[node] || v < -kSlack || w < -kSlack || v + w > 1 + kSlack) continue;
        done[node] = true;
        ++painted;
        paint(node, triangles[t], Eigen::Vector3d(1 - v - w, v, w));
      }
    }
  }
  return painted;
}

}  // namespace

UvCanvas draw_uv_canvas(const ControlMesh& generic_head, int side) {
  const SubdivisionHierarchy hierarchy(generic_head.triangles,
                                       static_cast<int>(generic_head.positions.size()), kLevel);
  const std::vector<Eigen::Vector3d> positions =
      evaluate_surface(hierarchy, generic_head.positions, {}, kLevel);
  const std::vector<Eigen::Vector3i>& triangles = hierarchy.triangles(kLevel);
  const std::vector<Eigen::Vector3d> normals = compute_vertex_normals(positions, triangles);
  UvCanvas canvas;
  canvas.side = side;
  const std::size_t count = static_cast<std::size_t>(side) * side;
  canvas.positions.resize(count);
  canvas.normals.resize(count, Eigen::Vector3d::UnitZ());
  const std::size_t painted =
      rasterise(triangles, evaluate_uv(hierarchy, generic_head.uv, kLevel), side,
                [&](std::size_t node, const Eigen::Vector3i& corners, const Eigen::Vector3d& weights) {
                  Eigen::Vector3d position = Eigen::Vector3d::Zero(), normal = position;
                  for (int i = 0; i < 3; ++i) {
                    position += weights[i] * positions[corners[i]];
                    normal += weights[i] * normals[corners[i]];
                  }
                  canvas.positions[node] = position;
                  if (normal.norm() > 1e-9) canvas.normals[node] = normal.normalized();
                });
  if (painted != count) throw InvalidInput("the generic head does not cover its (u,v) square");
  for (const auto& [name, point] : generic_head.annotations.landmarks) {
    canvas.landmarks[name] = position_at(point, generic_head.triangles, generic_head.positions);
    Eigen::Vector2d& uv = canvas.landmark_uv[name];
    uv.setZero();
    for (int i = 0; i < 3; ++i)
      uv += point.weights[i] * generic_head.uv[generic_head.triangles[point.triangle_idx][i]];
  }
  return canvas;
}

std::vector<double> draw_region(const ControlMesh& generic_head, int side, const RegionEdge& edge) {
  const auto found = generic_head.annotations.regions.find(edge.region);
  if (found == generic_head.annotations.regions.end())
    throw InvalidInput("the generic head has no region '" + edge.region + "'");
  std::vector<double> weights(generic_head.positions.size(), 0);
  for (const int vertex_idx : found->second) weights.at(vertex_idx) = 1;
  for (int pass = 0; pass < edge.shrink; ++pass) {
    const std::vector<double> wider = weights;
    for (const Eigen::Vector3i& triangle : generic_head.triangles) {
      if (wider[triangle[0]] * wider[triangle[1]] * wider[triangle[2]] != 0) continue;
      for (int i = 0; i < 3; ++i) weights[triangle[i]] = 0;
    }
  }
  for (int pass = 0; pass < edge.rings; ++pass) {
    std::vector<double> sums = weights, counts(weights.size(), 1);
    for (const Eigen::Vector3i& triangle : generic_head.triangles) {
      for (int i = 0; i < 3; ++i) {
        sums[triangle[i]] += 0.5 * (weights[triangle[(i + 1) % 3]] + weights[triangle[(i + 2) % 3]]);
        counts[triangle[i]] += 1;
      }
    }
    for (std::size_t v = 0; v < weights.size(); ++v) weights[v] = sums[v] / counts[v];
  }
  std::vector<double> drawn(static_cast<std::size_t>(side) * side, 0);
  rasterise(generic_head.triangles, generic_head.uv, side,
            [&](std::size_t node, const Eigen::Vector3i& corners, const Eigen::Vector3d& w) {
              drawn[node] =
                  w[0] * weights[corners[0]] + w[1] * weights[corners[1]] + w[2] * weights[corners[2]];
            });
  return drawn;
}

}  // namespace phiz
