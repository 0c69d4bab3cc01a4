#include "stages/geometry/half_edge.h"

#include <string>
#include <utility>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

std::string edge_name(int a, int b) {
  return "edge " + std::to_string(a) + "-" + std::to_string(b);
}

void check_triangles(std::span<const Eigen::Vector3i> triangles, int vertex_count) {
  CONTRACT(vertex_count >= 0 && triangles.size() < (std::size_t{1} << 29));
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Eigen::Vector3i& v = triangles[t];
    if (v.minCoeff() < 0 || v.maxCoeff() >= vertex_count)
      throw InvalidInput("triangle " + std::to_string(t) + " refers to a vertex that is not there");
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0])
      throw InvalidInput("triangle " + std::to_string(t) + " names a vertex twice");
  }
}

/// Outgoing half-edges of each vertex, compressed.
struct Outgoing {
  explicit Outgoing(const HalfEdgeMesh& mesh, int vertex_count)
      : offsets(static_cast<std::size_t>(vertex_count) + 1, 0), half_edges(mesh.half_edge_count()) {
    for (int h = 0; h < mesh.half_edge_count(); ++h) ++offsets[mesh.from(h) + 1];
    for (int v = 0; v < vertex_count; ++v) offsets[v + 1] += offsets[v];
    std::vector<int> next(offsets.begin(), offsets.end() - 1);
    for (int h = 0; h < mesh.half_edge_count(); ++h) half_edges[next[mesh.from(h)]++] = h;
  }
  int count(int v) const { return offsets[v + 1] - offsets[v]; }
  std::span<const int> of(int v) const {
    return {half_edges.data() + offsets[v], static_cast<std::size_t>(count(v))};
  }
  std::vector<int> offsets, half_edges;
};

[[noreturn]] void throw_shared_edge(const HalfEdgeMesh& mesh, int a, int b, int first, int second) {
  int sharing = 0;
  for (int h = 0; h < mesh.half_edge_count(); ++h)
    sharing += (mesh.from(h) == a && mesh.to(h) == b) || (mesh.from(h) == b && mesh.to(h) == a);
  if (sharing > 2)
    throw InvalidInput(
        edge_name(a, b) + " has " + std::to_string(sharing) + " triangles, at most 2 are allowed",
        "the mesh must be a manifold: remove duplicate or inner faces");
  throw InvalidInput("triangles " + std::to_string(mesh.triangle(first)) + " and " +
                         std::to_string(mesh.triangle(second)) + " disagree in orientation along " +
                         edge_name(a, b),
                     "all triangles must be counter-clockwise seen from outside");
}

/// The half-edge opposite h, or kNone. Looks only among the edges of the end with fewer triangles, so that a
/// vertex of very many triangles costs no more than the others.
int find_twin(const HalfEdgeMesh& mesh, const Outgoing& outgoing, int h) {
  const int a = mesh.from(h), b = mesh.to(h);
  const bool at_start = outgoing.count(a) <= outgoing.count(b);
  const int centre = at_start ? a : b, other = at_start ? b : a;
  int twin = HalfEdgeMesh::kNone;
  for (const int out : outgoing.of(centre)) {
    const int in = mesh.prev(out);
    const int same = at_start ? out : in, opposite = at_start ? in : out;
    const int same_end = at_start ? mesh.to(out) : mesh.from(in);
    const int opposite_end = at_start ? mesh.from(in) : mesh.to(out);
    if (same_end == other && same != h) throw_shared_edge(mesh, a, b, h, same);
    if (opposite_end == other) {
      if (twin != HalfEdgeMesh::kNone) throw_shared_edge(mesh, a, b, twin, opposite);
      twin = opposite;
    }
  }
  return twin;
}

}  // namespace

HalfEdgeMesh::HalfEdgeMesh(std::span<const Eigen::Vector3i> triangles, int vertex_count) {
  check_triangles(triangles, vertex_count);
  const int count = static_cast<int>(3 * triangles.size());
  from_.resize(count);
  for (int h = 0; h < count; ++h) from_[h] = triangles[h / 3][h % 3];
  twin_.assign(count, kNone);
  edge_.resize(count);
  outgoing_.assign(vertex_count, kNone);
  border_.assign(vertex_count, 0);

  const Outgoing outgoing(*this, vertex_count);
  for (int h = 0; h < count; ++h) {
    if (twin_[h] == kNone) {
      twin_[h] = find_twin(*this, outgoing, h);
      if (twin_[h] != kNone) twin_[twin_[h]] = h;
      edge_[h] = edge_count_++;
    } else {
      edge_[h] = edge_[twin_[h]];
    }
  }

  for (int v = 0; v < vertex_count; ++v) {
    if (outgoing.count(v) == 0) continue;
    outgoing_[v] = outgoing.of(v).front();
    for (const int h : outgoing.of(v))
      if (twin_[h] == kNone) outgoing_[v] = h, border_[v] = 1;
    int turned = 0;
    int h = outgoing_[v];
    do ++turned, h = rotate(h);
    while (h != kNone && h != outgoing_[v]);
    if (turned != outgoing.count(v))
      throw InvalidInput("the triangles at vertex " + std::to_string(v) + " form more than one fan",
                         "split the vertex, one for each fan");
  }
}

int HalfEdgeMesh::valence(int v) const {
  int edges = border_[v];
  int h = outgoing_[v];
  if (h == kNone) return 0;
  do ++edges, h = rotate(h);
  while (h != kNone && h != outgoing_[v]);
  return edges;
}

std::vector<int> HalfEdgeMesh::ring(int v) const {
  std::vector<int> vertices;
  int h = outgoing_[v];
  if (h == kNone) return vertices;
  while (true) {
    vertices.push_back(to(h));
    const int following = rotate(h);
    if (following == kNone) vertices.push_back(from(prev(h)));
    if (following == kNone || following == outgoing_[v]) return vertices;
    h = following;
  }
}

std::vector<std::vector<int>> HalfEdgeMesh::border_loops() const {
  std::vector<std::vector<int>> loops;
  std::vector<char> seen(vertex_count(), 0);
  for (int start = 0; start < half_edge_count(); ++start) {
    if (!is_border_edge(start) || seen[from(start)]) continue;
    std::vector<int> loop;
    for (int h = start; !seen[from(h)]; h = outgoing_[to(h)]) {
      seen[from(h)] = 1;
      loop.push_back(from(h));
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

}  // namespace phiz
