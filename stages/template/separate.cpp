#include "stages/template/separate.h"

#include <algorithm>
#include <cmath>

#include "stages/geometry/normals.h"
#include "stages/subdivide/subdivide.h"
#include "stages/template/improve.h"
#include "stages/template/self_intersection.h"
#include "stages/template/tidy.h"

namespace phiz {

int separate_crossings(ControlMesh& mesh, const SeparateOptions& options) {
  if (options.level > 3) {  // most of it at a level that is looked through faster
    SeparateOptions coarser = options;
    coarser.level = 3;
    separate_crossings(mesh, coarser);
  }
  const int n = static_cast<int>(mesh.positions.size());
  const SubdivisionHierarchy hierarchy(mesh.triangles, n, options.level);
  const int per_triangle = 1 << (2 * options.level);
  for (int round = 0;; ++round) {
    const auto positions = evaluate_surface(hierarchy, mesh.positions, {}, options.level);
    const auto crossings = find_self_intersections(positions, hierarchy.triangles(options.level));
    if (crossings.empty() || round == options.max_rounds) return static_cast<int>(crossings.size());
    std::vector<bool> moved(mesh.positions.size(), false);
    for (const auto& pair : crossings) {
      for (const int t : {pair.first, pair.second}) {
        for (int k = 0; k < 3; ++k) {
          const int v = mesh.triangles[t / per_triangle][k];
          moved[v] = moved[mesh.annotations.mirror[v]] = true;
        }
      }
    }
    const auto normals = compute_vertex_normals(mesh.positions, mesh.triangles);
    for (int v = 0; v < n; ++v) {
      const int image = mesh.annotations.mirror[v];
      if (!moved[v] || image < v) continue;
      Eigen::Vector3d p = mesh.positions[v] - options.step_mm * normals[v];
      p = p.unaryExpr(&on_grain).eval();
      if (image == v) p[0] = 0;
      mesh.positions[v] = p;
      mesh.positions[image] = {-p[0], p[1], p[2]};
    }
  }
}

bool settle(ControlMesh& mesh, double min_angle_deg, int max_rounds) {
  for (int round = 0; round < max_rounds; ++round) {
    SeparateOptions options;
    if (round > 0) options.max_rounds = 6;  // only what the widening brought about
    const bool is_apart = separate_crossings(mesh, options) == 0;
    const auto angles = min_angles_deg(mesh.positions, mesh.triangles);
    const double sharpest = *std::min_element(angles.begin(), angles.end());
    if (sharpest >= min_angle_deg) return is_apart;
    widen_sharp_triangles(mesh, min_angle_deg);
  }
  return false;
}

}  // namespace phiz
