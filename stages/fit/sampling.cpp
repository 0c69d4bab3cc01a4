#include "stages/fit/sampling.h"

#include <Eigen/Geometry>
#include <map>
#include <utility>

#include "stages/geometry/error.h"
#include "stages/geometry/half_edge.h"

namespace phiz {

StencilMatrix compose_stencils(const SubdivisionHierarchy& hierarchy, int level) {
  CONTRACT(level >= 0 && level <= hierarchy.level_count());
  StencilMatrix composed(hierarchy.vertex_count(0), hierarchy.vertex_count(0));
  composed.setIdentity();
  for (int k = 1; k <= level; ++k) {
    const auto& stencils = hierarchy.stencils(k);
    const int old_count = hierarchy.vertex_count(k - 1);
    std::vector<Eigen::Triplet<double>> entries;
    for (int v = 0; v < old_count; ++v) entries.emplace_back(v, v, 1.0);
    for (std::size_t row = 0; row + 1 < stencils.offsets.size(); ++row)
      for (int e = stencils.offsets[row]; e < stencils.offsets[row + 1]; ++e)
        entries.emplace_back(old_count + static_cast<int>(row), stencils.vertices[e], stencils.weights[e]);
    StencilMatrix refine(hierarchy.vertex_count(k), old_count);
    refine.setFromTriplets(entries.begin(), entries.end());
    composed = (refine * composed).pruned();
  }
  composed.makeCompressed();
  return composed;
}

StencilMatrix normalised_laplacian(const std::vector<Eigen::Vector3i>& triangles,
                                   const std::vector<Eigen::Vector3d>& positions) {
  const int count = static_cast<int>(positions.size());
  const HalfEdgeMesh mesh(triangles, count);
  std::map<std::pair<int, int>, double> weights;
  for (const auto& t : triangles) {
    for (int i = 0; i < 3; ++i) {
      const int a = t[i], b = t[(i + 1) % 3], c = t[(i + 2) % 3];
      const Eigen::Vector3d u = positions[a] - positions[c], v = positions[b] - positions[c];
      const double cotangent = u.dot(v) / std::max(u.cross(v).norm(), 1e-12);
      weights[std::minmax(a, b)] += std::max(cotangent, 0.1);
    }
  }
  std::vector<double> sums(count, 0.0);
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& [edge, weight] : weights) {
    for (const auto& [from, to] : {edge, std::pair(edge.second, edge.first)}) {
      if (mesh.is_border_vertex(from) && !mesh.is_border_vertex(to)) continue;
      entries.emplace_back(from, to, weight);
      sums[from] += weight;
    }
  }
  for (auto& e : entries) e = {e.row(), e.col(), -e.value() / sums[e.row()]};
  for (int v = 0; v < count; ++v)
    if (sums[v] > 0) entries.emplace_back(v, v, 1.0);
  StencilMatrix laplacian(count, count);
  laplacian.setFromTriplets(entries.begin(), entries.end());
  laplacian.makeCompressed();
  return laplacian;
}

}  // namespace phiz
