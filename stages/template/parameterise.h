#pragma once

#include <span>

#include "stages/template/layout.h"
#include "stages/template/mapped_surface.h"
#include "stages/template/reference.h"

namespace phiz {

struct MapOptions {
  double lower_corner =
      0.27;  ///< where along the half neck loop, from the throat, the square has its lower corner
  double upper_corner = 0.80;  ///< and its upper one
  int max_iterations = 200;
  double relative_tolerance = 1e-5;
};

/// Maps a half head to the right half of the (u,v) square, one-to-one: mean value coordinates (Floater 2003)
/// to start, then relax_map, where `scales` say how large each place should become. Throws NumericalFailure
/// if the start folds. O(V^1.5) per iteration.
MappedSurface map_half_head(const HalfHead& head, std::span<const Layout::Scale> scales,
                            const MapOptions& options = {});

/// Lowers the symmetric Dirichlet energy of a one-to-one map by SLIM (Rabinovich et al. 2017). `sizes` (one a
/// triangle, > 0) are the lengths sought in (u,v) per mm, up to a common factor. Vertices slide along the
/// border of the square, all but its corners; those of the mirror line stay on it.
void relax_map(MappedSurface& surface, std::span<const double> sizes, const MapOptions& options = {});

}  // namespace phiz
