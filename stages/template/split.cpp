#include "stages/template/split.h"

#include <algorithm>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

/// Point of a centripetal-free Catmull-Rom segment between p1 and p2.
Eigen::Vector2d catmull_rom(const std::array<Eigen::Vector2d, 4>& p, double t) {
  const double t2 = t * t, t3 = t2 * t;
  return 0.5 * ((2 * p[1]) + (p[2] - p[0]) * t + (2 * p[0] - 5 * p[1] + 4 * p[2] - p[3]) * t2 +
                (3 * p[1] - p[0] - 3 * p[2] + p[3]) * t3);
}

/// The four control points of the spline's segment from point k of a curve to the next.
std::array<Eigen::Vector2d, 4> spline_segment(const Layout::Curve& curve, const std::vector<HalfMesh::Vertex>& vertices,
                                              std::size_t k) {
  const std::size_t n = curve.points.size();
  const auto at = [&](std::size_t i) { return vertices[curve.points[i % n]].uv; };
  const Eigen::Vector2d a = at(k), b = at(k + 1);
  Eigen::Vector2d before = 2 * a - b, after = 2 * b - a;
  const bool mirrored_start = a[0] == 0.5, mirrored_end = b[0] == 0.5;
  if (!curve.corner[k % n] && (curve.closed || k > 0)) before = at(k + n - 1);
  else if (!curve.corner[k % n] && mirrored_start) before = {1 - b[0], b[1]};
  if (!curve.corner[(k + 1) % n] && (curve.closed || k + 2 < n)) after = at(k + 2);
  else if (!curve.corner[(k + 1) % n] && mirrored_end) after = {1 - a[0], a[1]};
  return {before, a, b, after};
}

/// Parameter of the middle in length on the surface.
double middle_parameter(const std::array<Eigen::Vector2d, 4>& segment, const SurfaceLookup& surface) {
  constexpr int kSteps = 64;
  std::array<double, kSteps + 1> length{};
  Eigen::Vector3d last = surface.position(segment[1]);
  for (int k = 1; k <= kSteps; ++k) {
    const Eigen::Vector3d p = surface.position(catmull_rom(segment, static_cast<double>(k) / kSteps));
    length[k] = length[k - 1] + (p - last).norm();
    last = p;
  }
  int k = 1;
  while (k < kSteps && length[k] < 0.5 * length[kSteps]) ++k;
  const double share = (0.5 * length[kSteps] - length[k - 1]) / std::max(length[k] - length[k - 1], 1e-12);
  return (k - 1 + std::clamp(share, 0.0, 1.0)) / kSteps;
}

}  // namespace

HalfMesh split_triangles(const HalfMesh& mesh, const Layout& layout, const SurfaceLookup& surface,
                         std::vector<std::vector<int>>& curves) {
  HalfMesh fine;
  fine.vertices = mesh.vertices;
  std::map<std::pair<int, int>, int> middles;
  const auto add_middle = [&](int a, int b, const HalfMesh::Vertex& vertex, int curve) {
    const int m = static_cast<int>(fine.vertices.size());
    middles[std::minmax(a, b)] = m;
    fine.vertices.push_back(vertex);
    if (curve >= 0) {
      fine.curve_edges[std::minmax(a, m)] = curve;
      fine.curve_edges[std::minmax(m, b)] = curve;
    }
    return m;
  };
  curves.assign(layout.curves.size(), {});
  for (std::size_t c = 0; c < layout.curves.size(); ++c) {
    const auto& curve = layout.curves[c];
    const std::size_t n = curve.points.size();
    for (std::size_t k = 0; k < n; ++k) {
      curves[c].push_back(curve.points[k]);
      if (k + 1 == n && !curve.closed) break;
      const int a = curve.points[k], b = curve.points[(k + 1) % n];
      const auto known = middles.find(std::minmax(a, b));
      if (known != middles.end()) {
        curves[c].push_back(known->second);
        continue;
      }
      Eigen::Vector2d uv = 0.5 * (mesh.vertices[a].uv + mesh.vertices[b].uv);
      const bool straight = (mesh.vertices[a].on_mirror() && mesh.vertices[b].on_mirror()) ||
                            (mesh.vertices[a].on_neck() && mesh.vertices[b].on_neck());
      if (curve.held && !straight) {
        const auto segment = spline_segment(curve, mesh.vertices, k);
        uv = catmull_rom(segment, middle_parameter(segment, surface));
      }
      if (uv[0] <= 0 || uv[0] > 0.5 || uv[1] <= 0 || uv[1] >= 1) {
        if (!straight) throw InvalidInput("curve '" + curve.name + "' swings out of the half square");
      }
      curves[c].push_back(add_middle(a, b, {uv, curve.held}, static_cast<int>(c)));
    }
  }
  for (const auto& t : mesh.triangles) {
    std::array<int, 3> m{};
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      const auto known = middles.find(std::minmax(a, b));
      const Eigen::Vector2d uv = 0.5 * (mesh.vertices[a].uv + mesh.vertices[b].uv);
      m[k] = known != middles.end() ? known->second : add_middle(a, b, {uv, false}, -1);
    }
    fine.triangles.push_back({t[0], m[0], m[2]});
    fine.triangles.push_back({m[0], t[1], m[1]});
    fine.triangles.push_back({m[2], m[1], t[2]});
    fine.triangles.push_back({m[0], m[1], m[2]});
  }
  return fine;
}

}  // namespace phiz
