#include "stages/template/check_parts.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "stages/subdivide/subdivide.h"

namespace phiz::check_parts {
namespace {

/// Whether the border of a set of triangles is one closed loop that visits no vertex twice.
bool has_simple_border(const ControlMesh& head, const std::vector<bool>& inside) {
  std::set<std::pair<int, int>> edges;
  for (std::size_t t = 0; t < inside.size(); ++t) {
    if (!inside[t]) continue;
    for (int k = 0; k < 3; ++k) {
      const int a = head.triangles[t][k], b = head.triangles[t][(k + 1) % 3];
      if (edges.erase({b, a}) == 0) edges.insert({a, b});
    }
  }
  std::map<int, int> next;
  for (const auto& [a, b] : edges) {
    if (!next.insert({a, b}).second) return false;
  }
  if (next.empty()) return false;
  std::size_t length = 1;
  for (int v = next.begin()->second; v != next.begin()->first; ++length) {
    const auto step = next.find(v);
    if (step == next.end() || length > next.size()) return false;
    v = step->second;
  }
  return length == next.size();
}

using TrianglesAt = std::vector<std::vector<int>>;  ///< per vertex

TrianglesAt list_triangles_at(const ControlMesh& head) {
  TrianglesAt triangles_at(head.positions.size());
  for (std::size_t t = 0; t < head.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) triangles_at[head.triangles[t][k]].push_back(static_cast<int>(t));
  }
  return triangles_at;
}

/// Takes the connected part that holds `seed` out of `left`.
std::vector<bool> take_part(const ControlMesh& head, const TrianglesAt& triangles_at, int seed,
                            std::vector<bool>& left) {
  std::vector<bool> part(left.size(), false);
  std::vector<int> front = {seed};
  while (!front.empty()) {
    const int t = front.back();
    front.pop_back();
    if (!left[t]) continue;
    left[t] = false, part[t] = true;
    for (int k = 0; k < 3; ++k) {
      const auto& next = triangles_at[head.triangles[t][k]];
      front.insert(front.end(), next.begin(), next.end());
    }
  }
  return part;
}

std::vector<bool> grow(const ControlMesh& head, const TrianglesAt& triangles_at,
                       const std::vector<bool>& part) {
  std::vector<bool> grown = part;
  for (std::size_t t = 0; t < part.size(); ++t) {
    for (int k = 0; part[t] && k < 3; ++k) {
      for (const int other : triangles_at[head.triangles[t][k]]) grown[other] = true;
    }
  }
  return grown;
}

struct AreaSum {
  double surface = 0, square = 0, worst = 0;
  double mean() const { return std::sqrt(surface / square); }  ///< mm on the surface per unit of (u,v)
  void add(const ControlMesh& head, const Eigen::Vector3i& t) {
    const Eigen::Vector3d u = head.positions[t[1]] - head.positions[t[0]],
                          v = head.positions[t[2]] - head.positions[t[0]];
    surface += u.cross(v).norm() / 2;
    square += doubled_area(head.uv[t[0]], head.uv[t[1]], head.uv[t[2]]) / 2;
    worst = std::max(worst, compute_stretches(head, t)[0]);
  }
};

/// How far along the border of the square, counter-clockwise from (0,0), in [0,4); none off it.
std::optional<double> find_border_place(const Eigen::Vector2d& uv) {
  if (uv.minCoeff() < 0 || uv.maxCoeff() > 1) return std::nullopt;
  if (uv[1] == 0 && uv[0] < 1) return uv[0];
  if (uv[0] == 1 && uv[1] < 1) return 1 + uv[1];
  if (uv[1] == 1 && uv[0] > 0) return 3 - uv[0];
  if (uv[0] == 0) return 4 - uv[1];
  return std::nullopt;
}

void check_border(const ControlMesh& head, const HalfEdgeMesh& mesh, Report& report) {
  std::size_t off = 0;
  int corners = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const auto& uv = head.uv[v];
    off += find_border_place(uv).has_value() != mesh.is_border_vertex(v);
    corners += (uv[0] == 0 || uv[0] == 1) && (uv[1] == 0 || uv[1] == 1);
  }
  report.add_none("vertices on the neck loop only or on the square's border only", off);
  report.add("corners of the square with a vertex", std::to_string(corners), "4", corners == 4);
  if (off > 0) return;
  double turns = 0;
  bool onwards = true;
  const std::vector<int> loop = mesh.border_loops().front();
  for (std::size_t k = 0; k < loop.size(); ++k) {
    const double here = *find_border_place(head.uv[loop[k]]);
    double step = *find_border_place(head.uv[loop[(k + 1) % loop.size()]]) - here;
    if (step <= 0) step += 4;
    onwards = onwards && step < 2;
    turns += step / 4;
  }
  report.add("turns of the neck loop round the square", number(turns, 1), "1.0",
             onwards && std::abs(turns - 1) < 1e-9);
}

}  // namespace

std::vector<bool> find_triangles_inside(const ControlMesh& head, const std::vector<int>& region) {
  std::vector<bool> in_region(head.positions.size(), false), inside;
  for (const int v : region) in_region[v] = true;
  for (const auto& t : head.triangles)
    inside.push_back(in_region[t[0]] && in_region[t[1]] && in_region[t[2]]);
  return inside;
}

Eigen::Vector2d compute_stretches(const ControlMesh& head, const Eigen::Vector3i& t) {
  Eigen::Matrix2d duv;
  duv << head.uv[t[1]] - head.uv[t[0]], head.uv[t[2]] - head.uv[t[0]];
  if (duv.determinant() == 0) return {0, 0};
  Eigen::Matrix<double, 3, 2> dp;
  dp << head.positions[t[1]] - head.positions[t[0]], head.positions[t[2]] - head.positions[t[0]];
  const Eigen::Matrix<double, 3, 2> jacobian = dp * duv.inverse();
  return Eigen::JacobiSVD<Eigen::Matrix<double, 3, 2>>(jacobian).singularValues();
}

Loops find_loops_around(const ControlMesh& head, const std::vector<int>& region) {
  std::vector<bool> left = find_triangles_inside(head, region);
  const TrianglesAt triangles_at = list_triangles_at(head);
  Loops loops;
  loops.rings.assign(left.size(), -1);
  bool any = false;
  int fewest = Loops::kMost;
  for (std::size_t seed = 0; seed < left.size(); ++seed) {
    if (!left[seed]) continue;
    any = true;
    std::vector<bool> part = take_part(head, triangles_at, static_cast<int>(seed), left);
    int count = 0;
    while (count < Loops::kMost && has_simple_border(head, part)) {
      for (std::size_t t = 0; t < part.size(); ++t) {
        if (part[t] && (loops.rings[t] < 0 || loops.rings[t] > count)) loops.rings[t] = count;
      }
      ++count;
      part = grow(head, triangles_at, part);
    }
    fewest = std::min(fewest, count);
  }
  loops.fewest = any ? fewest : 0;
  return loops;
}

bool check_domain(const ControlMesh& head, const HalfEdgeMesh& mesh, Report& report) {
  report.picture = "uv";
  check_border(head, mesh, report);
  constexpr int kLevels = 4;
  const bool is_small = mesh.vertex_count() <= 20'000;
  const SubdivisionHierarchy hierarchy(head.triangles, mesh.vertex_count(), is_small ? kLevels : 0);
  std::size_t turned_at_all = 0;
  for (int level = 0; level <= hierarchy.level_count(); ++level) {
    const auto uv = evaluate_uv(hierarchy, head.uv, level);
    std::size_t turned = 0;
    for (const auto& t : hierarchy.triangles(level))
      turned += !(doubled_area(uv[t[0]], uv[t[1]], uv[t[2]]) > 0);
    report.add_none("triangles turned over in (u,v), level " + std::to_string(level), turned);
    turned_at_all += turned;
  }
  if (turned_at_all > 0) return false;
  AreaSum all, face;
  std::vector<bool> in_face(head.triangles.size(), false);
  const auto region = head.annotations.regions.find("face");
  if (region != head.annotations.regions.end()) in_face = find_triangles_inside(head, region->second);
  for (std::size_t t = 0; t < head.triangles.size(); ++t) {
    all.add(head, head.triangles[t]);
    if (in_face[t]) face.add(head, head.triangles[t]);
  }
  report.add("area of all triangles in (u,v)", number(all.square, 6), "1", std::abs(all.square - 1) < 1e-5);
  report.add_within("share of the square that the face has", 100 * face.square, 40, 60, 1, " %");
  report.picture = "stretch";
  if (face.square > 0) {
    report.add_at_most("mean length of a texel on the face at 512 x 512", face.mean() / 512, 0.5, 3, " mm");
    report.add_at_most("worst stretch over the face, of its mean", face.worst / face.mean(), 4, 2);
  }
  report.add_at_most("worst stretch over all, of its mean", all.worst / all.mean(), 20, 2);
  return true;
}

}  // namespace phiz::check_parts
