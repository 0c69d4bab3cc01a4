#include "stages/template/reference.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include "stages/geometry/error.h"
#include "stages/geometry/half_edge.h"
#include "stages/geometry/point_index.h"
#include "stages/geometry/surface_index.h"
#include "stages/template/opening.h"

namespace phiz {
namespace {

constexpr double kSymmetryTolerance_mm = 1.0;
constexpr double kSnap_mm = 1.0;  ///< vertices so near the neck plane are moved onto it

/// Piece of each vertex, numbered by size, largest first; isolated vertices are -1.
std::vector<int> number_pieces(std::span<const Eigen::Vector3i> triangles, int vertex_count) {
  std::vector<int> root(vertex_count);
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  std::vector<int> size(vertex_count, 0);
  for (const auto& t : triangles) {
    for (int k = 1; k < 3; ++k) {
      const int a = find(t[0]), b = find(t[k]);
      root[std::max(a, b)] = std::min(a, b);
    }
  }
  for (const auto& t : triangles) ++size[find(t[0])];
  std::vector<int> order;
  for (int v = 0; v < vertex_count; ++v) {
    if (size[v] > 0) order.push_back(v);
  }
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return size[a] > size[b]; });
  std::vector<int> number(vertex_count, -1), piece(vertex_count, -1);
  for (std::size_t k = 0; k < order.size(); ++k) number[order[k]] = static_cast<int>(k);
  for (int v = 0; v < vertex_count; ++v) piece[v] = number[find(v)];
  return piece;
}

/// Moves every vertex to the mean of itself and its mirror partner; those on the mirror line to x = 0.
void make_symmetric(std::vector<Eigen::Vector3d>& positions, const std::vector<int>& vertices) {
  std::vector<Eigen::Vector3f> points;
  for (const int v : vertices) points.push_back(positions[v].cast<float>());
  const PointIndex index(points);
  std::vector<Eigen::Vector3d> symmetric(positions);
  for (const int v : vertices) {
    const Eigen::Vector3d image(-positions[v][0], positions[v][1], positions[v][2]);
    const auto hit = index.find_nearest(image.cast<float>(), kSymmetryTolerance_mm);
    if (hit.point_idx < 0) {
      throw InvalidInput("the reference is not symmetric: vertex " + std::to_string(v) + " has no partner",
                         "average it with its mirror image first");
    }
    const Eigen::Vector3d& partner = positions[vertices[hit.point_idx]];
    symmetric[v] = 0.5 * (positions[v] + Eigen::Vector3d(-partner[0], partner[1], partner[2]));
    if (vertices[hit.point_idx] == v) symmetric[v][0] = 0;
  }
  positions = symmetric;
}

/// Keeps the part of a triangle mesh on the positive side of a plane.
class PlaneCut {
 public:
  PlaneCut(HalfHead& head, const Plane& plane) : head_(head) {
    for (auto& p : head_.positions) {
      double d = plane.normal.dot(p) - plane.offset_mm;
      if (std::abs(d) < kSnap_mm) p -= d * plane.normal, d = 0;
      distances_.push_back(d);
    }
    std::vector<Eigen::Vector3i> kept;
    for (const auto& t : head_.triangles) clip(t, kept);
    head_.triangles = kept;
  }

 private:
  void clip(const Eigen::Vector3i& t, std::vector<Eigen::Vector3i>& kept) {
    std::vector<int> polygon;
    bool above = false;
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      if (distances_[a] >= 0) polygon.push_back(a);
      if (distances_[a] > 0) above = true;
      if (distances_[a] * distances_[b] < 0) polygon.push_back(cross(a, b));
    }
    if (!above) return;
    for (std::size_t k = 1; k + 1 < polygon.size(); ++k)
      kept.push_back({polygon[0], polygon[k], polygon[k + 1]});
  }

  int cross(int a, int b) {
    if (a > b) std::swap(a, b);
    const auto [found, is_new] = crossings_.insert({{a, b}, static_cast<int>(head_.positions.size())});
    if (is_new) {
      const double t = distances_[a] / (distances_[a] - distances_[b]);
      head_.positions.push_back((1 - t) * head_.positions[a] + t * head_.positions[b]);
      distances_.push_back(0);
    }
    return found->second;
  }

  HalfHead& head_;
  std::vector<double> distances_;
  std::map<std::pair<int, int>, int> crossings_;
};

void drop_unused(HalfHead& head) {
  std::vector<int> renamed(head.positions.size(), -1);
  for (const auto& t : head.triangles) {
    for (int k = 0; k < 3; ++k) renamed[t[k]] = 0;
  }
  std::vector<Eigen::Vector3d> positions;
  for (std::size_t v = 0; v < renamed.size(); ++v) {
    if (renamed[v] < 0) continue;
    renamed[v] = static_cast<int>(positions.size());
    positions.push_back(head.positions[v]);
  }
  for (auto& t : head.triangles) t = {renamed[t[0]], renamed[t[1]], renamed[t[2]]};
  head.positions = positions;
}

/// Runs of a closed loop whose inner vertices lie off the mirror line, with their ends on it.
std::vector<std::vector<int>> runs_beside_mirror(const std::vector<int>& loop,
                                                 const std::vector<Eigen::Vector3d>& positions) {
  const std::size_t n = loop.size();
  const auto on = [&](std::size_t k) { return positions[loop[k % n]][0] == 0; };
  std::vector<std::vector<int>> runs;
  for (std::size_t k = 0; k < n; ++k) {
    if (!on(k) || on(k + 1)) continue;
    std::vector<int> run = {loop[k]};
    std::size_t j = k + 1;
    for (; !on(j); ++j) run.push_back(loop[j % n]);
    run.push_back(loop[j % n]);
    runs.push_back(run);
  }
  return runs;
}

/// Closes all openings of the half head but the neck.
void close_openings(HalfHead& head, const SurfaceIndex* inside) {
  const HalfEdgeMesh mesh(head.triangles, static_cast<int>(head.positions.size()));
  const auto loops = mesh.border_loops();
  bool neck_found = false;
  for (const auto& loop : loops) {
    const auto runs = runs_beside_mirror(loop, head.positions);
    if (runs.empty()) {
      close_patch(head, loop, inside);
      continue;
    }
    // Of the runs across the mirror line the lowest is the neck.
    const auto height = [&](const std::vector<int>& run) {
      double sum = 0;
      for (const int v : run) sum += head.positions[v][1];
      return sum / static_cast<double>(run.size());
    };
    const auto neck = std::min_element(runs.begin(), runs.end(),
                                       [&](const auto& a, const auto& b) { return height(a) < height(b); });
    neck_found = true;
    for (auto run = runs.begin(); run != runs.end(); ++run) {
      if (run != neck) close_pocket(head, *run);
    }
  }
  if (!neck_found) throw InvalidInput("the reference has no opening at the neck");
}

void require_disk(const HalfHead& head) {
  const HalfEdgeMesh mesh(head.triangles, static_cast<int>(head.positions.size()));
  const int euler = mesh.vertex_count() - mesh.edge_count() + mesh.triangle_count();
  if (mesh.border_loops().size() != 1 || euler != 1) {
    throw InvalidInput("the closed reference is no disk: " + std::to_string(mesh.border_loops().size()) +
                       " border loops, Euler characteristic " + std::to_string(euler));
  }
}

}  // namespace

HalfHead close_reference(std::span<const Eigen::Vector3d> positions,
                         std::span<const Eigen::Vector3i> triangles, const Plane& neck) {
  const int vertex_count = static_cast<int>(positions.size());
  const std::vector<int> piece = number_pieces(triangles, vertex_count);
  std::vector<int> skin;
  for (int v = 0; v < vertex_count; ++v) {
    if (piece[v] == 0) skin.push_back(v);
  }
  if (skin.empty()) throw InvalidInput("the reference has no triangles");
  HalfHead head;
  head.positions.assign(positions.begin(), positions.end());
  make_symmetric(head.positions, skin);

  std::vector<Eigen::Vector3i> others;
  for (const auto& t : triangles) {
    if (piece[t[0]] != 0) {
      others.push_back(t);
      continue;
    }
    const Eigen::Vector3d x(head.positions[t[0]][0], head.positions[t[1]][0], head.positions[t[2]][0]);
    if (x.maxCoeff() <= 0)
      head.triangles.push_back(t);
    else if (x.minCoeff() < 0)
      throw InvalidInput("a triangle of the reference straddles the mirror line");
  }
  PlaneCut(head, neck);
  drop_unused(head);
  std::optional<SurfaceIndex> inside;
  if (!others.empty()) {
    std::vector<Eigen::Vector3f> points;
    for (const auto& p : positions) points.push_back(p.cast<float>());
    inside.emplace(points, others);
  }
  close_openings(head, inside ? &*inside : nullptr);
  require_disk(head);
  return head;
}

}  // namespace phiz
