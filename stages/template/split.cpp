#include "stages/template/split.h"

#include <algorithm>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

/// The piece of a curve's spline from its point k to the next, through places on the surface.
Rail find_rail(const Layout::Curve& curve, const std::vector<HalfMesh::Vertex>& vertices, std::size_t k,
               const SurfaceLookup& surface) {
  const std::size_t n = curve.points.size();
  const auto at = [&](std::size_t i) { return surface.position(vertices[curve.points[i % n]].uv); };
  const auto image = [](const Eigen::Vector3d& p) { return Eigen::Vector3d(-p[0], p[1], p[2]); };
  const Eigen::Vector3d a = at(k), b = at(k + 1);
  Eigen::Vector3d before = 2 * a - b, after = 2 * b - a;
  if (!curve.corner[k % n] && (curve.closed || k > 0))
    before = at(k + n - 1);
  else if (!curve.corner[k % n] && vertices[curve.points[k]].on_mirror())
    before = image(b);
  if (!curve.corner[(k + 1) % n] && (curve.closed || k + 2 < n))
    after = at(k + 2);
  else if (!curve.corner[(k + 1) % n] && vertices[curve.points[(k + 1) % n]].on_mirror())
    after = image(a);
  return {{before, a, b, after}, 0.5};
}

/// A layout's point inside one held curve (no corner, no crossing) may slide as well: between its new
/// neighbours.
void add_rails_of_points(const Layout& layout, const std::vector<std::vector<int>>& curves,
                         const SurfaceLookup& surface, HalfMesh& fine) {
  std::vector<int> uses(layout.points.size(), 0);
  for (const auto& curve : layout.curves) {
    for (const int p : curve.points) ++uses[p];
  }
  for (std::size_t c = 0; c < layout.curves.size(); ++c) {
    const auto& curve = layout.curves[c];
    if (!curve.held) continue;
    const std::size_t n = curves[c].size();  // points and middles in turn
    const auto at = [&](std::size_t i) { return surface.position(fine.vertices[curves[c][i % n]].uv); };
    for (std::size_t k = 0; k < curve.points.size(); ++k) {
      auto& vertex = fine.vertices[curve.points[k]];
      const bool inner = curve.closed || (k > 0 && k + 1 < curve.points.size());
      if (!inner || curve.corner[k] || uses[curve.points[k]] > 1 || vertex.on_mirror() || vertex.on_neck())
        continue;
      const std::size_t i = 2 * k + n;
      vertex.rail = Rail{{at(i - 2), at(i - 1), at(i + 1), at(i + 2)}, 0.5};
    }
  }
}

/// The new vertex in the middle of edge k of a feature curve: on the curve's rail where the curve is held.
HalfMesh::Vertex find_curve_middle(const HalfMesh& mesh, const Layout::Curve& curve, std::size_t k,
                                   const SurfaceLookup& surface) {
  const HalfMesh::Vertex& a = mesh.vertices[curve.points[k]];
  const HalfMesh::Vertex& b = mesh.vertices[curve.points[(k + 1) % curve.points.size()]];
  HalfMesh::Vertex middle;
  middle.uv = 0.5 * (a.uv + b.uv);
  const bool straight = (a.on_mirror() && b.on_mirror()) || (a.on_neck() && b.on_neck());
  if (!curve.held || straight) return middle;
  middle.rail = find_rail(curve, mesh.vertices, k, surface);
  middle.uv = surface.descend_to(middle.rail->at(0.5), middle.uv);
  const auto& uv = middle.uv;
  if (uv[0] <= 0 || uv[0] >= 0.5 || uv[1] <= 0 || uv[1] >= 1)
    throw InvalidInput("curve '" + curve.name + "' (line " + std::to_string(curve.line) +
                       ") swings out of the half square");
  return middle;
}

}  // namespace

Eigen::Vector3d Rail::at(double t) const {
  const auto& p = points;
  const double t2 = t * t, t3 = t2 * t;
  return 0.5 * ((2 * p[1]) + (p[2] - p[0]) * t + (2 * p[0] - 5 * p[1] + 4 * p[2] - p[3]) * t2 +
                (3 * p[1] - p[0] - 3 * p[2] + p[3]) * t3);
}

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
      const HalfMesh::Vertex middle = find_curve_middle(mesh, curve, k, surface);
      curves[c].push_back(add_middle(a, b, middle, static_cast<int>(c)));
    }
  }
  add_rails_of_points(layout, curves, surface, fine);
  for (const auto& t : mesh.triangles) {
    std::array<int, 3> m{};
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      const auto known = middles.find(std::minmax(a, b));
      Eigen::Vector2d uv = 0.5 * (mesh.vertices[a].uv + mesh.vertices[b].uv);
      const bool on_neck = uv[0] == 0 || uv[1] == 0 || uv[1] == 1;
      if (known == middles.end() && !on_neck) {
        const Eigen::Vector3d target =
            0.5 * (surface.position(mesh.vertices[a].uv) + surface.position(mesh.vertices[b].uv));
        uv = surface.descend_to(target, uv);
      }
      m[k] = known != middles.end() ? known->second : add_middle(a, b, {uv, false, std::nullopt}, -1);
    }
    fine.triangles.push_back({t[0], m[0], m[2]});
    fine.triangles.push_back({m[0], t[1], m[1]});
    fine.triangles.push_back({m[2], m[1], t[2]});
    fine.triangles.push_back({m[0], m[1], m[2]});
  }
  return fine;
}

}  // namespace phiz
