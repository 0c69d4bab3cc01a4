#pragma once

#include "formats/control_mesh.h"

namespace phiz {

struct SeparateOptions {
  int level = 4;          ///< of the surface that must not cross itself
  double step_mm = 0.06;  ///< that the control vertices of crossing triangles go back in a round
  int max_rounds = 30;
};

/// Moves control vertices inwards along their normals, little by little, where the subdivided surface crosses
/// itself (lips that touch). Symmetric. Returns the number of crossing pairs that are left.
int separate_crossings(ControlMesh& mesh, const SeparateOptions& options = {});

/// separate_crossings and widen_sharp_triangles in turn, until neither has anything to do. Whether that was
/// reached.
bool settle(ControlMesh& mesh, double min_angle_deg, int max_rounds = 6);

}  // namespace phiz
