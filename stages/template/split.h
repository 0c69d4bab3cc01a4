#pragma once

#include "stages/template/mapped_surface.h"
#include "stages/template/triangulate.h"

namespace phiz {

/// Splits every triangle into four. The middle of an edge of a held curve lies where the curve's spline
/// (Catmull-Rom through its points in space, broken at its corners, mirrored at the mirror line) comes to the
/// surface, and may slide along it; other middles lie on the surface next to the middle of the edge.
/// `curves[c]` receives curve c's vertices in order, with the new ones.
HalfMesh split_triangles(const HalfMesh& mesh, const Layout& layout, const SurfaceLookup& surface,
                         std::vector<std::vector<int>>& curves);

}  // namespace phiz
