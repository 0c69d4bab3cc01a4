#pragma once

#include <span>

#include "formats/control_mesh.h"
#include "stages/template/domain.h"
#include "stages/template/layout.h"
#include "stages/template/limit_fit.h"
#include "stages/template/mapped_surface.h"

namespace phiz {

/// The surface a layout is laid on, from a reference head: a mesh in mm, upright, looking along +z, symmetric
/// to 1 mm, with eyes, mouth and the neck as its only openings; other pieces inside (eyeballs) carry the
/// eyes' patches. The layout's neck plane cuts it, its scales shape its map. Throws InvalidInput,
/// NumericalFailure. Seconds.
MappedSurface map_reference(std::span<const Eigen::Vector3d> positions,
                            std::span<const Eigen::Vector3i> triangles, const Layout& layout);

/// The same from a generic head that is there already: the right half of its subdivided surface (level 2),
/// with its own (u,v). Throws InvalidInput where that is not one-to-one onto the half square.
MappedSurface map_head(const ControlMesh& head);

struct TemplateOptions {
  int coarse_rounds = 8;  ///< of flips and relaxation, before the triangles are split
  int coarse_sweeps = 5;  ///< of relaxation in each round
  int relax_sweeps = 80;  ///< after the split
  int settle_rounds = 6;  ///< of separating what crosses itself and widening what is sharp
  LimitFitOptions limit;  ///< rounds = 0 leaves the control vertices on the surface
  DomainOptions domain;
};

/// Builds a generic head: constrained Delaunay triangulation of the layout, flips towards regular valences
/// and even triangles on the surface, split 1:4, relaxation along surface and curves, mirror image,
/// annotations; then the control vertices are moved until the subdivided surface lies on the given one, (u,v)
/// is relaxed, and Draco's order taken. Landmarks are the layout's places on the surface. Deterministic.
/// Throws InvalidInput with the reason where the layout makes no head. About a second.
ControlMesh build_generic_head(const Layout& layout, const MappedSurface& surface,
                               const TemplateOptions& options = {});

}  // namespace phiz
