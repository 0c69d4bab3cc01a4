#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "stages/subdivide/subdivide.h"

namespace phiz {

/// What fast evaluation of the displaced surface needs of the connectivity: one for all subjects, immutable.
///
/// A surface's points lie in one buffer: [0, V) final positions, [V, 2V) the same before the displacement of
/// their level; V is the vertex count of the finest level. Entries of `rows` point into the first half,
/// those of `spokes` into either.
class SurfacePlan {
 public:
  /// The levels 0 .. hierarchy.level_count(). O(V); about 150 bytes a vertex of the finest level, 0.1 s for
  /// 400,000.
  explicit SurfacePlan(const SubdivisionHierarchy& hierarchy);

  static constexpr int kPointBytes = 16;
  static constexpr int kRowLength = 8;     ///< of the regular rule: 2 x 1/2, 2 x 1/8, 4 x -1/16
  static constexpr int kSpokesAbove0 = 6;  ///< neighbours of a new vertex
  struct Level {
    int first = 0, count = 0;  ///< the vertices that this level adds (and may displace)
    /// kRowLength a new vertex. A first entry < 0 says: not regular, row -1 - entry of the general ones.
    std::vector<int> rows;
    std::vector<int> general_offsets, general_points;  ///< points: in bytes, as in rows
    std::vector<float> general_weights;
    int spokes_per_vertex = kSpokesAbove0;
    /// Neighbours in order; closed fans. Of an open fan the last entries are the vertex itself; shorter
    /// closed fans repeat their first neighbour. Triangles without an area weigh nothing.
    std::vector<int> spokes;
    /// New vertices whose row or parents name vertex v of the coarser level: what to refine when it moves.
    std::vector<int> dependent_offsets, dependents;
    /// Vertices of this level whose fan has v - first (undisplaced) as a neighbour or centre.
    std::vector<int> fan_offsets, fans;
  };

  int level_count() const { return static_cast<int>(levels_.size()) - 1; }
  int vertex_count(int level) const { return levels_[level].first + levels_[level].count; }
  int capacity() const { return vertex_count(level_count()); }  ///< V
  const Level& level(int k) const { return levels_[k]; }

  /// The vertices of one level that depend on one control vertex, ascending: whose undisplaced position does,
  /// and whose final one does. Kept for the coarse levels, where finding them would take longer than
  /// computing them; 5 KB a control vertex.
  struct Support {
    std::span<const int> refined, displaced;
  };
  static constexpr int kSupportLevels = 3;  ///< levels 0, 1, 2
  Support support(int control_vertex_idx, int level) const;

 private:
  void add_supports();

  std::vector<Level> levels_;
  std::vector<int> support_offsets_, supports_;  ///< by control vertex, level, refined or displaced
};

}  // namespace phiz
