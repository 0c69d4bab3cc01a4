#include <algorithm>

#include "stages/geometry/error.h"
#include "stages/geometry/half_edge.h"
#include "stages/geometry/parallel.h"
#include "stages/subdivide/edge_rules.h"
#include "stages/subdivide/subdivide.h"

namespace phiz {
namespace {

constexpr int kMaxLevels = 10;
constexpr std::size_t kGrain = 4096;

using Stencils = SubdivisionHierarchy::Stencils;
using Ring = SubdivisionHierarchy::Ring;

/// The first half-edge of every edge.
std::vector<int> first_half_edges(const HalfEdgeMesh& mesh) {
  std::vector<int> firsts;
  firsts.reserve(mesh.edge_count());
  for (int h = 0; h < mesh.half_edge_count(); ++h)
    if (mesh.edge(h) == static_cast<int>(firsts.size())) firsts.push_back(h);
  return firsts;
}

/// Four triangles for each: the corners in their order, then the middle one.
std::vector<Eigen::Vector3i> split_triangles(const HalfEdgeMesh& mesh) {
  std::vector<Eigen::Vector3i> fine(4 * static_cast<std::size_t>(mesh.triangle_count()));
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    Eigen::Vector3i middles;
    for (int i = 0; i < 3; ++i) middles[i] = mesh.vertex_count() + mesh.edge(3 * t + i);
    for (int i = 0; i < 3; ++i) fine[4 * t + i] = {mesh.from(3 * t + i), middles[i], middles[(i + 2) % 3]};
    fine[4 * t + 3] = middles;
  }
  return fine;
}

std::vector<Ring> compute_rings(const HalfEdgeMesh& mesh, const std::vector<int>& firsts) {
  std::vector<Ring> rings(firsts.size());
  const auto middle = [&](int h) { return mesh.vertex_count() + mesh.edge(h); };
  for (std::size_t e = 0; e < firsts.size(); ++e) {
    const int h = firsts[e], twin = mesh.twin(h);
    rings[e] = {mesh.to(h), middle(mesh.next(h)), middle(mesh.prev(h)), mesh.from(h), -1, -1};
    if (twin == HalfEdgeMesh::kNone) continue;
    rings[e][4] = middle(mesh.next(twin));
    rings[e][5] = middle(mesh.prev(twin));
  }
  return rings;
}

/// Rows are computed in chunks, in parallel, and put together in order.
Stencils compute_stencils(const HalfEdgeMesh& mesh, const std::vector<int>& firsts) {
  std::vector<Stencils> chunks(firsts.empty() ? 0 : (firsts.size() - 1) / kGrain + 1);
  parallel_for(firsts.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    Stencils& chunk = chunks[begin / kGrain];
    chunk.vertices.reserve(8 * (end - begin));
    chunk.weights.reserve(8 * (end - begin));
    std::vector<Weighted> row;
    for (std::size_t e = begin; e < end; ++e) {
      compute_edge_rule(mesh, firsts[e], row);
      for (const Weighted& entry : row) {
        chunk.vertices.push_back(entry.vertex_idx);
        chunk.weights.push_back(entry.weight);
      }
      chunk.offsets.push_back(static_cast<int>(chunk.vertices.size()));
    }
  });
  std::size_t entries = 0;
  for (const Stencils& chunk : chunks) entries += chunk.vertices.size();
  Stencils all;
  all.offsets.reserve(firsts.size() + 1);
  all.vertices.reserve(entries);
  all.weights.reserve(entries);
  all.offsets.push_back(0);
  for (const Stencils& chunk : chunks) {
    const int base = static_cast<int>(all.vertices.size());
    for (const int offset : chunk.offsets) all.offsets.push_back(base + offset);
    all.vertices.insert(all.vertices.end(), chunk.vertices.begin(), chunk.vertices.end());
    all.weights.insert(all.weights.end(), chunk.weights.begin(), chunk.weights.end());
  }
  return all;
}

}  // namespace

SubdivisionHierarchy::SubdivisionHierarchy(std::span<const Eigen::Vector3i> triangles, int vertex_count,
                                           int levels) {
  CONTRACT(levels >= 0 && levels <= kMaxLevels);
  levels_.resize(static_cast<std::size_t>(levels) + 1);
  levels_[0].vertex_count = vertex_count;
  levels_[0].triangles.assign(triangles.begin(), triangles.end());
  if (levels == 0) HalfEdgeMesh(triangles, vertex_count);  // only to refuse what is no manifold
  for (int level = 1; level <= levels; ++level) {
    const Level& coarse = levels_[level - 1];
    CONTRACT(coarse.triangles.size() < (std::size_t{1} << 26));
    const HalfEdgeMesh mesh(coarse.triangles, coarse.vertex_count);
    const std::vector<int> firsts = first_half_edges(mesh);
    Level& fine = levels_[level];
    fine.vertex_count = coarse.vertex_count + mesh.edge_count();
    fine.triangles = split_triangles(mesh);
    fine.rings = compute_rings(mesh, firsts);
    fine.stencils = compute_stencils(mesh, firsts);
  }
}

Eigen::Vector2i SubdivisionHierarchy::parents(int level, int vertex_idx) const {
  CONTRACT(level >= 1 && level <= level_count() && vertex_idx >= 0 && vertex_idx < vertex_count(level));
  const int old_count = vertex_count(level - 1);
  if (vertex_idx < old_count) return {vertex_idx, vertex_idx};
  const Ring& ring = levels_[level].rings[vertex_idx - old_count];
  return {ring[3], ring[0]};
}

}  // namespace phiz
