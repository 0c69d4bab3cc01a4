#include "stages/adapt/compliance.h"

#include "stages/adapt/matching.h"
#include "stages/adapt/stellar_mesh.h"
#include "stages/geometry/error.h"

namespace phiz {
namespace {

/// Splits every pair's edge, every face alone by a vertex inside: each edge that stays is the one opposite
/// the new vertex in both its faces.
void split_blocks(std::span<const Eigen::Vector3i> triangles, const BlockMatching& matching,
                  CompliantMesh& made) {
  StellarMesh mesh(triangles, made.vertex_count);
  const auto is_whole = [&](int f) {  // not split yet: no corner is new
    const auto& corners = mesh.corners(f);
    return std::max({corners[0], corners[1], corners[2]}) < made.vertex_count;
  };
  for (int f = 0; f < static_cast<int>(triangles.size()); ++f) {
    if (!is_whole(f)) continue;
    const int h = matching.half_edge[f];
    if (h < 0) {
      const auto [a, b, c] = mesh.corners(f);
      made.added.push_back({{a, b, c}});
      mesh.split_face(f);
    } else {
      const int edge = StellarMesh::half_edge(f, h % 3);
      made.added.push_back({{mesh.from(edge), mesh.to(edge), -1}});
      mesh.split_edge(edge);
    }
  }
  made.vertex_count = mesh.vertex_count();
  made.triangles.clear();
  for (int f = 0; f < mesh.face_slots(); ++f) {
    const auto& [a, b, c] = mesh.corners(f);
    made.triangles.emplace_back(a, b, c);
  }
}

}  // namespace

CompliantMesh make_compliant(std::span<const Eigen::Vector3i> triangles,
                             std::span<const Eigen::Vector3d> positions, BlockOrder order) {
  const HalfEdgeMesh mesh(triangles, static_cast<int>(positions.size()));
  BlockMatching matching = match_longest_first(mesh, positions);
  if (order == BlockOrder::kMatching) complete_matching(mesh, positions, matching);
  CompliantMesh made;
  made.vertex_count = static_cast<int>(positions.size());
  for (int f = 0; f < mesh.triangle_count(); ++f) {
    const int h = matching.half_edge[f];
    if (h < 0)
      ++made.inside_singles;
    else if (mesh.twin(h) < 0)
      ++made.border_singles;
    else if (mesh.twin(h) < h)
      ++made.pairs;
  }
  if (order == BlockOrder::kLongestFirst) {
    split_blocks(triangles, matching, made);
    return made;
  }
  for (int f = 0; f < mesh.triangle_count(); ++f) {
    const int h = matching.half_edge[f];
    made.triangles.emplace_back(mesh.from(h), mesh.to(h), mesh.from(mesh.prev(h)));
  }
  return made;
}

bool is_compliant(std::span<const Eigen::Vector3i> triangles, int vertex_count) {
  const HalfEdgeMesh mesh(triangles, vertex_count);
  for (int f = 0; f < mesh.triangle_count(); ++f) {
    const int t = mesh.twin(3 * f);
    if (t != HalfEdgeMesh::kNone && t % 3 != 0) return false;
  }
  return true;
}

}  // namespace phiz
