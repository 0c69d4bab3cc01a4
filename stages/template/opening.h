#pragma once

#include <vector>

#include "stages/geometry/surface_index.h"
#include "stages/template/reference.h"

namespace phiz {

/// Closes a border loop (in the order of its half-edges) by columns of triangles between its two long sides.
/// The patch is lifted onto `inside` where that is seen through the opening (a little behind it along the
/// margin); it may be null.
void close_patch(HalfHead& head, const std::vector<int>& loop, const SurfaceIndex* inside);

/// Closes an opening across the mirror line: `run` is its half, from mirror line to mirror line in the order
/// of the half-edges. The new surface bends inwards by a quarter of the gap.
void close_pocket(HalfHead& head, const std::vector<int>& run);

}  // namespace phiz
