#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "stages/fit/sampling.h"
#include "stages/subdivide/subdivide.h"

namespace phiz {

/// What folds are looked for and mended with; the references outlive it. O(vertices of the finest level) a
/// look.
struct FoldSearch {
  using Positions = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
  const SubdivisionHierarchy& hierarchy;
  std::span<const StencilMatrix> samples;  ///< of levels 1, 2, ... as compose_stencils gives them
  const StencilMatrix& laplacian;          ///< of the control mesh at rest
  const Positions& rest;                   ///< control vertices where nothing is folded
};

/// Control triangles that are folded at `x`: they, or a triangle that subdivision makes of them, face more
/// than 84 degrees away from where they face at rest. Ascending.
std::vector<int> find_folded(const FoldSearch& surface, const FoldSearch::Positions& x);

/// Lays folds flat: around folded triangles the displacement from the rest shape becomes the smoothest one
/// (least bending) that meets its surroundings, ring by ring wider until nothing is folded, at most `rings`
/// wide; around those that this leaves folded, the one with the least stretch. Vertices farther away and
/// those of the border stay; other terms of a fit (bindings, constraints) are not asked. x becomes the state
/// with the fewest folded control triangles, whose number is returned. Nothing folded: x is not touched.
/// Deterministic. At most 4 rings looks and solves; milliseconds where little is folded.
int lay_folds_flat(const FoldSearch& surface, FoldSearch::Positions& x, int rings = 4);

}  // namespace phiz
