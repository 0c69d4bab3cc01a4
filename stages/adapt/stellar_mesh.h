#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace phiz {

/// Triangles of an oriented 2-manifold, with or without border, that stellar operators change: an edge or a
/// face is split by a new vertex, and welded again. Nothing but the current mesh is stored. Half-edge
/// 4 f + i runs from corner i to corner i+1 of face f (i in 0 .. 2). Faces and vertices live in slots: a weld
/// frees slots and the next split takes them, last freed first. 40 bytes a triangle, vertices included; each
/// operator O(1).
///
/// Source: Velho 2003 (stellar subdivision grammars); Goldenstein, Vogler, Velho 2005, section 4.
class StellarMesh {
 public:
  static constexpr int kNone = -1;

  /// Slots are the given indices; isolated vertices are allowed. Throws InvalidInput where the triangles are
  /// no oriented 2-manifold, as HalfEdgeMesh does. O(F).
  StellarMesh(std::span<const Eigen::Vector3i> triangles, int vertex_count);

  int vertex_count() const { return vertex_count_; }  ///< that live
  int face_count() const { return face_count_; }
  int vertex_slots() const { return static_cast<int>(vertices_.size()); }
  int face_slots() const { return static_cast<int>(faces_.size()); }
  bool is_vertex(int v) const { return vertices_[v].level >= 0; }
  bool is_face(int f) const { return faces_[f].level >= 0; }

  static int half_edge(int f, int i) { return 4 * f + i; }
  static int face(int h) { return h >> 2; }
  static int next(int h) { return (h & 3) == 2 ? h - 2 : h + 1; }
  static int prev(int h) { return (h & 3) == 0 ? h + 2 : h - 1; }
  int twin(int h) const { return faces_[h >> 2].twin[h & 3]; }  ///< kNone on the border
  int from(int h) const { return faces_[h >> 2].corner[h & 3]; }
  int to(int h) const { return from(next(h)); }
  const std::array<int, 3>& corners(int f) const { return faces_[f].corner; }
  /// An outgoing half-edge; at a border vertex the one whose right side is the border. kNone where isolated.
  int outgoing(int v) const { return vertices_[v].outgoing; }
  int rotate(int h) const { return twin(prev(h)); }  ///< the next outgoing one, counter-clockwise; or kNone

  bool is_border_vertex(int v) const { return outgoing(v) != kNone && twin(outgoing(v)) == kNone; }
  int valence(int v) const;                ///< edges at v
  std::vector<int> star(int v) const;      ///< faces about v, counter-clockwise
  std::vector<int> link(int v) const;      ///< vertices about v, from border to border where there is one
  int find_half_edge(int a, int b) const;  ///< from a to b; kNone: there is none. O(valence)
  std::vector<std::vector<int>> border_loops() const;

  /// A small number on each vertex and face for the hierarchy above. Splits give new faces the level of the
  /// one they came from, new vertices 0. Levels are >= 0.
  int vertex_level(int v) const { return vertices_[v].level; }
  int face_level(int f) const { return faces_[f].level; }
  void set_vertex_level(int v, int level) { vertices_[v].level = level; }
  void set_face_level(int f, int level) { faces_[f].level = level; }

  /// Splits h = a -> b of face f = (a, b, c) and, inside, of g = (b, a, d) by a new vertex v. f's slot
  /// becomes (c, a, v), g's (d, b, v), new slots (b, c, v) and (a, d, v). Returns v.
  int split_edge(int h);
  /// Whether the edge from(h) - v = to(h) can be welded with the one beyond v: v has four edges, or three on
  /// the border along it, and the edge that comes to be is not there already. O(valence).
  bool can_weld_edge(int h) const;
  /// The inverse of split_edge, for h = a -> v of the slot that becomes f = (a, b, c); g = (b, a, d) is what
  /// had v -> d. Corner 0 of both starts the welded edge. The caller knows that it can be done.
  void weld_edge(int h);

  /// Splits f = (a, b, c) by a new vertex v inside: f's slot becomes (a, b, v), new ones (b, c, v), (c, a,
  /// v).
  int split_face(int f);
  bool can_weld_face(int v) const;  ///< v lies inside and has three edges
  /// The inverse, for h the side opposite v of the slot that stays; corner 0 starts h.
  void weld_face(int h);

  /// Every broken invariant in words, at most 20; empty: none. O(F).
  std::vector<std::string> validate() const;
  std::size_t memory_bytes() const;

 private:
  struct alignas(32) Face {
    std::array<int, 3> corner;
    int level = 0;  ///< -1: the slot is free, and corner[0] names the next free one
    std::array<int, 3> twin;
  };
  struct Vertex {
    int outgoing = kNone;  ///< of a free slot: the next free one
    int level = 0;         ///< -1: free
  };
  struct Move {
    int before, after;
  };

  int take_vertex();
  int take_face(int level);
  void release_vertex(int v);
  void release_face(int f);
  void set_face(int f, const std::array<int, 3>& corner, const std::array<int, 3>& twin);
  void join(int outer, int h) {
    if (outer != kNone) faces_[outer >> 2].twin[outer & 3] = h;
  }
  void move_outgoing(int v, Move first, Move second);
  void validate_face(int f, std::vector<std::string>& broken) const;
  void validate_vertex(int v, int corners_there, std::vector<std::string>& broken) const;
  void validate_free(std::vector<std::string>& broken) const;

  std::vector<Face> faces_;
  std::vector<Vertex> vertices_;
  int vertex_count_ = 0, face_count_ = 0;
  int free_vertex_ = kNone, free_face_ = kNone;
};

}  // namespace phiz
