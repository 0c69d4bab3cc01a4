#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

namespace phiz {

/// Half-edge connectivity of an oriented 2-manifold of triangles, with or without border. Half-edge 3 t + i
/// runs from corner i to corner i+1 of triangle t; faces are implicit. Immutable. O(F) memory: 4 ints a
/// half-edge.
class HalfEdgeMesh {
 public:
  /// Throws InvalidInput, naming the first offender, if an edge has more than two triangles, two triangles
  /// disagree in orientation, a vertex is not a single fan, a triangle names a vertex twice, or an index is
  /// out of range. Isolated vertices are allowed. O(F).
  HalfEdgeMesh(std::span<const Eigen::Vector3i> triangles, int vertex_count);

  static constexpr int kNone = -1;
  int vertex_count() const { return static_cast<int>(outgoing_.size()); }
  int half_edge_count() const { return static_cast<int>(twin_.size()); }
  int triangle_count() const { return half_edge_count() / 3; }
  int edge_count() const { return edge_count_; }

  int next(int h) const { return h % 3 == 2 ? h - 2 : h + 1; }
  int prev(int h) const { return h % 3 == 0 ? h + 2 : h - 1; }
  int twin(int h) const { return twin_[h]; }  ///< kNone on the border
  int from(int h) const { return from_[h]; }
  int to(int h) const { return from_[next(h)]; }
  int triangle(int h) const { return h / 3; }
  int edge(int h) const { return edge_[h]; }  ///< dense index; numbered in the order of their first half-edge

  /// An outgoing half-edge; for a border vertex the one from which counter-clockwise turning visits the whole
  /// fan (its clockwise neighbour is the border). kNone for an isolated vertex.
  int outgoing(int v) const { return outgoing_[v]; }
  /// Counter-clockwise neighbour among the outgoing half-edges of from(h): twin(prev(h)); kNone at the
  /// border.
  int rotate(int h) const { return twin_[prev(h)]; }
  bool is_border_vertex(int v) const { return border_[v]; }
  bool is_border_edge(int h) const { return twin_[h] == kNone; }
  int valence(int v) const;  ///< number of edges at v

  /// One-ring in counter-clockwise order; for a border vertex from border neighbour to border neighbour.
  std::vector<int> ring(int v) const;
  /// Border loops, each as vertices in the order of their border half-edges.
  std::vector<std::vector<int>> border_loops() const;

 private:
  std::vector<int> twin_, from_, edge_, outgoing_;
  std::vector<char> border_;
  int edge_count_ = 0;
};

}  // namespace phiz
