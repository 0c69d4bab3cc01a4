#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "stages/deform/deform.h"
#include "stages/geometry/scan_surface.h"
#include "stages/geometry/step_keeper.h"

namespace phiz {

struct MuscleGuess {
  std::vector<double> parameters;  ///< of the rig, each from its minimum to twice its maximum
  double cost = 0;                 ///< truncated squared distance, mm^2 area
};

/// Which designed muscles explain a scan: the rig's parameters by Gauss-Newton on matched distances (mostly
/// along the normals), few and small ones preferred, from a closed, a half and a fully open jaw. `neutral`
/// holds the subject at the vertices of `triangles`; `skip` marks those not to be matched. Deterministic; 2 s
/// for 6,000 points and 54 parameters.
MuscleGuess guess_muscles(const ScanSurface& scan, const Deformation& rig, const NeutralSurface& neutral,
                          const std::vector<Eigen::Vector3i>& triangles, const std::vector<bool>& skip,
                          const Eigen::Isometry3d& scan_from_neutral, StepKeeper* keeper = nullptr);

}  // namespace phiz
