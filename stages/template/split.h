#pragma once

#include "stages/template/mapped_surface.h"
#include "stages/template/triangulate.h"

namespace phiz {

/// Splits every triangle into four. The middle of an edge of a held curve lies on the curve's spline (Catmull-Rom
/// through its points in (u,v), broken at its corners), half way in length on the surface, and is held; other middles
/// lie half way in (u,v). `curves[c]` receives curve c's vertices in order, with the new ones.
HalfMesh split_triangles(const HalfMesh& mesh, const Layout& layout, const SurfaceLookup& surface,
                         std::vector<std::vector<int>>& curves);

}  // namespace phiz
