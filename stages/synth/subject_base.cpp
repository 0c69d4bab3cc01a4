#include <cmath>

#include "stages/geometry/error.h"
#include "stages/geometry/half_edge.h"
#include "stages/synth/anatomy.h"

namespace phiz {
namespace {

struct RegionUse {
  std::string name;
  int smoothing_passes = 0;  ///< for regions that fields end with
};

std::vector<int> find_neck_loop(const HalfEdgeMesh& mesh) {
  std::vector<int> next(mesh.vertex_count(), -1);
  int border_edges = 0, start = -1;
  for (int h = 0; h < mesh.half_edge_count(); ++h) {
    if (mesh.twin(h) != HalfEdgeMesh::kNone) continue;
    next[mesh.from(h)] = mesh.to(h);
    if (start < 0) start = mesh.from(h);
    ++border_edges;
  }
  if (start < 0) throw InvalidInput("the generic head has no open neck");
  std::vector<int> loop = {start};
  while (next[loop.back()] != start) loop.push_back(next[loop.back()]);
  if (static_cast<int>(loop.size()) != border_edges) {
    throw InvalidInput("the generic head has more than one open border");
  }
  return loop;
}

/// 1 in the region, 0 outside, averaged over one-rings a few times, then subdivided like a position.
std::vector<double> smooth_region(const ControlMesh& head, const std::vector<int>& region,
                                  int smoothing_passes, const SubdivisionHierarchy& hierarchy, int level) {
  std::vector<double> weights(head.positions.size(), 0);
  for (const int vertex_idx : region) weights.at(vertex_idx) = 1;
  for (int pass = 0; pass < smoothing_passes; ++pass) {
    std::vector<double> sums = weights, counts(weights.size(), 1);
    for (const Eigen::Vector3i& triangle : head.triangles) {
      for (int i = 0; i < 3; ++i) {
        sums[triangle[i]] += 0.5 * (weights[triangle[(i + 1) % 3]] + weights[triangle[(i + 2) % 3]]);
        counts[triangle[i]] += 1;
      }
    }
    for (std::size_t v = 0; v < weights.size(); ++v) weights[v] = sums[v] / counts[v];
  }
  std::vector<Eigen::Vector3d> values(weights.size());
  for (std::size_t v = 0; v < weights.size(); ++v) values[v].setConstant(weights[v]);
  std::vector<double> fine;
  for (const Eigen::Vector3d& value : evaluate_surface(hierarchy, values, {}, level))
    fine.push_back(value.x());
  return fine;
}

/// Barycentric coordinates in a triangle of level-1 of vertex v of `level`, which lies on it.
Eigen::Vector3d place_in_parent(const SubdivisionHierarchy& hierarchy, int level, int vertex_idx,
                                const Eigen::Vector3i& parent) {
  const Eigen::Vector2i ends = hierarchy.parents(level, vertex_idx);
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i) weights[i] = 0.5 * ((parent[i] == ends[0]) + (parent[i] == ends[1]));
  return weights;
}

}  // namespace

SurfacePoint refine_surface_point(const SubdivisionHierarchy& hierarchy, int level,
                                  const SurfacePoint& point) {
  SurfacePoint found = point;
  for (int fine = 1; fine <= level; ++fine) {
    const Eigen::Vector3i& parent = hierarchy.triangles(fine - 1)[found.triangle_idx];
    SurfacePoint best;
    double best_least = -1e300;
    for (int child = 4 * found.triangle_idx; child < 4 * found.triangle_idx + 4; ++child) {
      Eigen::Matrix3d corners;
      for (int i = 0; i < 3; ++i) {
        corners.col(i) = place_in_parent(hierarchy, fine, hierarchy.triangles(fine)[child][i], parent);
      }
      const Eigen::Vector3d weights = corners.inverse() * found.weights;
      if (weights.minCoeff() <= best_least) continue;
      best_least = weights.minCoeff();
      best = {child, weights.cwiseMax(0)};
    }
    best.weights /= best.weights.sum();
    found = best;
  }
  return found;
}

SubjectBase make_subject_base(const ControlMesh& head, int level) {
  CONTRACT(level >= 0 && level <= 5);
  const HalfEdgeMesh mesh(head.triangles, static_cast<int>(head.positions.size()));
  find_neck_loop(mesh);
  const SubdivisionHierarchy hierarchy(head.triangles, mesh.vertex_count(), level);
  SubjectBase base;
  base.positions = evaluate_surface(hierarchy, head.positions, {}, level);
  base.triangles = hierarchy.triangles(level);
  base.neck_loop = find_neck_loop(HalfEdgeMesh(base.triangles, static_cast<int>(base.positions.size())));
  for (const auto& [name, point] : head.annotations.landmarks) {
    base.landmarks[name] = refine_surface_point(hierarchy, level, point);
  }
  const RegionUse uses[] = {{"ears", 2}, {"neck", 2}, {"scalp", 1}, {"lips", 1}, {"inner_mouth", 1}};
  for (const auto& [name, passes] : uses) {
    const auto region = head.annotations.regions.find(name);
    if (region == head.annotations.regions.end()) {
      throw InvalidInput("the generic head has no region '" + name + "'");
    }
    base.regions[name] = smooth_region(head, region->second, passes, hierarchy, level);
  }
  measure_anatomy(base);
  return base;
}

}  // namespace phiz
