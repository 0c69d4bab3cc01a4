#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "stages/adapt/stellar_mesh.h"

namespace phiz {

/// What one operator did, in slots: v split the edge a - b of f = (a, b, c) and g = (b, a, d), which became
/// f = (c, a, v), n = (b, c, v), g = (d, b, v), m = (a, d, v); or the other way round. On the border d, g and
/// m are -1. A list of these in order brings a copy of the index list up to date.
struct StellarChange {
  bool is_split = true;
  int vertex = -1;
  int a = -1, b = -1, c = -1, d = -1;
  int f = -1, n = -1, g = -1, m = -1;
};

/// Restricted binary multi-triangulation: every face is split by halving the edge between its corners 0 and
/// 1, together with the neighbour across it (both are a basic block); the new vertex becomes corner 2. Levels
/// interleave: faces of a block have one level, those of a split block the next, and neighbours differ by one
/// at most. Refining a face first refines the coarser neighbour across its edge, simplifying a vertex first
/// takes away finer ones about it, so every state is a conforming mesh and any order of requests is allowed.
/// Levels and slots are all that is stored: what a weld has to restore follows from them. Base vertices and
/// faces keep their slots, and welding everything gives the base back, slots and corners and all.
///
/// Source: Velho and Zorin 2001 (4-8 subdivision); Velho and Gomes 2000 (variable resolution 4-k meshes);
/// Goldenstein, Vogler, Velho 2005, section 4.
class MultiTriangulation {
 public:
  static constexpr int kMostLevel = 48;

  /// `base` must be compliant (make_compliant): the edge between corners 0 and 1 of a face lies on the border
  /// or is that of its neighbour too. Throws InvalidInput that names a face where it is not, or where the
  /// triangles are no oriented 2-manifold.
  MultiTriangulation(std::span<const Eigen::Vector3i> base, int vertex_count);

  const StellarMesh& mesh() const { return mesh_; }
  int base_vertex_count() const { return base_vertices_; }
  int base_face_count() const { return base_faces_; }
  int level(int f) const { return mesh_.face_level(f); }
  int vertex_level(int v) const { return mesh_.vertex_level(v); }  ///< 0: of the base

  /// The face whose block has to be split first so that f can be: f itself where nothing is in the way.
  int next_split(int f) const;
  /// Splits the block of f. next_split(f) == f and level(f) < kMostLevel.
  StellarChange split(int f);

  bool can_weld(int v) const;  ///< v is not of the base, and nothing finer hangs on it
  /// The vertex to weld first so that v (not of the base) can be: v itself where nothing is in the way.
  int next_weld(int v) const;
  /// What weld(v) would do; can_weld(v).
  StellarChange describe_weld(int v) const;
  StellarChange weld(int v);

  /// Splits f's block and, before, what is in its way. on_change(const StellarChange&) after each operator.
  template <class OnChange>
  void refine(int f, const OnChange& on_change) {
    for (int blocking = -1; blocking != f;) {
      blocking = next_split(f);
      on_change(split(blocking));
    }
  }
  /// Welds v and, before, what hangs on it.
  template <class OnChange>
  void simplify(int v, const OnChange& on_change) {
    for (int blocking = -1; blocking != v;) {
      blocking = next_weld(v);
      on_change(weld(blocking));
    }
  }

  /// Every broken invariant of mesh and levels in words, at most some 40; empty: none. O(F).
  std::vector<std::string> validate() const;

 private:
  bool is_newest(int h) const { return (h & 3) == 2; }  ///< of the corner where h starts

  StellarMesh mesh_;
  int base_vertices_, base_faces_;
};

}  // namespace phiz
