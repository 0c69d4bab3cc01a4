#pragma once

#include <vector>

#include "formats/control_mesh.h"
#include "stages/template/layout.h"
#include "stages/template/mapped_surface.h"
#include "stages/template/triangulate.h"

namespace phiz {

/// A half mesh unfolded to a whole one: the half's vertices keep their indices, the mirror images of those
/// off the mirror line follow in order. Triangles of the half first, then their images. mirror[v] as in
/// Annotations.
ControlMesh unfold(const HalfMesh& half, const std::vector<Eigen::Vector3d>& positions);

/// Regions, landmarks, boxes, bindings, constraints and planes of a layout on the mesh that was unfolded from
/// `half`. Throws InvalidInput where a region with two names reaches the mirror line: its curves do not close
/// it off.
void annotate(const Layout& layout, const HalfMesh& half, const SurfaceLookup& surface, ControlMesh& mesh);

}  // namespace phiz
