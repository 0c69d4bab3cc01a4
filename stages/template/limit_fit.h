#pragma once

#include "formats/control_mesh.h"
#include "stages/template/mapped_surface.h"

namespace phiz {

struct LimitFitOptions {
  int level = 2;  ///< whose vertices are drawn to the surface
  int rounds = 4;
  double tangential_weight = 0.02;  ///< of the distance along the surface, against 1 across it
  double smooth_weight = 0.05;      ///< of the change's Laplacian
  double stay_weight = 0.01;        ///< of the change itself
  double min_angle_deg = 15.5;      ///< vertices stay nearer to their start where a triangle would be sharper
};

/// Butterfly subdivision interpolates: control vertices on a surface do not put the limit surface on it.
/// Moves them so that the subdivided surface lies on the mapped one in the least-squares sense. Constrained
/// vertices do not ask for anything; the result is exactly mirror-symmetric. Returns the root mean square
/// distance before and after, mm.
struct LimitFitResult {
  double before_mm = 0, after_mm = 0;
};
LimitFitResult fit_limit(ControlMesh& mesh, const SurfaceLookup& surface,
                         const LimitFitOptions& options = {});

}  // namespace phiz
