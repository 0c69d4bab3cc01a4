#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "stages/subdivide/subdivide.h"

namespace phiz {

struct QuantiseOptions {
  double tolerance_mm = 0.02;      ///< of the finished surface to the given one and back, in (0, 5]
  double position_step_mm = 0.02;  ///< of the control vertices, in [1e-4, 10]; made smaller where it must be
  int level = 4;                   ///< finest level that is kept, 0 .. hierarchy.level_count()
};

struct QuantisedSurface {
  std::vector<Eigen::Vector3d> control_positions;    ///< whole steps, in the precision of float
  std::vector<std::vector<float>> displacements_mm;  ///< as in HeadAsset, whole steps
  std::vector<Eigen::Vector3d> positions;            ///< of the finest level, as evaluate_surface gives them
  double step_mm = 0, position_step_mm = 0;          ///< of displacements and of control positions
  double hausdorff_mm = 0;                           ///< measured, of the finest levels
};

/// Rounds a displaced surface so that few bits hold it. Level by level, each from the rounded level before:
/// a new vertex goes along its normal to where it meets the given surface, and that way is rounded, so that
/// errors of coarse levels are mended by finer ones instead of adding up. Where the measured distance exceeds
/// the tolerance the levels below are rounded to half steps and measured again, a few times; folds may keep a
/// handful of vertices farther away, which hausdorff_mm then tells. displacements_mm as in evaluate_surface.
/// Deterministic. Throws InvalidInput on options out of range. Level 4 (400,000 vertices): 3 s of processor
/// time, most of it for measuring.
QuantisedSurface quantise_surface(const SubdivisionHierarchy& hierarchy,
                                  std::span<const Eigen::Vector3d> control_positions,
                                  std::span<const std::vector<float>> displacements_mm,
                                  const QuantiseOptions& options);

/// Greatest distance of any vertex and any triangle's centre of one mesh to the other surface, both ways, mm.
/// Both have the same triangles.
double measure_hausdorff(std::span<const Eigen::Vector3d> first, std::span<const Eigen::Vector3d> second,
                         std::span<const Eigen::Vector3i> triangles);

}  // namespace phiz
