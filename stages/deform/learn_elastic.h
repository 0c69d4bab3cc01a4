#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "formats/control_mesh.h"
#include "stages/geometry/scan_surface.h"
#include "stages/geometry/step_keeper.h"
#include "stages/subdivide/subdivide.h"

namespace phiz {

/// One round of the elastic fit. Energies are in mm^4 (offset^2 x area): how much a mm of offset counts.
struct ElasticRound {
  int level = 1;         ///< at whose vertices the scan is matched, 1 .. 3
  double reach_mm = 3;   ///< farther matches are refused; below 1.9 the scan is measured along the normals
  double strain = 0.05;  ///< mm^2: price of (change of length)^2 over the surface
  double bending = 10;   ///< mm^4: of the bending of the displacement along the normals
  double hold = 0.001;   ///< price of leaving the rest shape; saturates at 0.3 mm, so it pins what is still
  int iterations = 3;
};

/// A subject's neutral head as an elastic skin: the control mesh moves, the displaced surface of the levels
/// follows (Modified Butterfly is linear in the control vertices) and is drawn onto a scan.
class ElasticSkin {
 public:
  /// `neutral_levels[k]`: the subject's displaced neutral surface at level k = 0 .. 3, in the scan's frame.
  /// `movable`: a control vertex each. The mouth's pocket (region inner_mouth, constrained vertices) is soft
  /// and not matched. Builds sparse patterns: 0.3 s.
  ElasticSkin(const ControlMesh& generic_head, const SubdivisionHierarchy& hierarchy,
              std::vector<std::vector<Eigen::Vector3d>> neutral_levels, const std::vector<bool>& movable);
  ~ElasticSkin();

  /// Control vertices drawn onto the scan from `rest` (what the muscles predict, or the neutral itself): the
  /// energies count from there. With a keeper every iteration is kept under the name `step`. Throws
  /// NumericalFailure. Deterministic; 0.2 s an iteration.
  std::vector<Eigen::Vector3d> fit(const ScanSurface& scan, const std::vector<Eigen::Vector3d>& rest,
                                   std::span<const ElasticRound> rounds, const std::string& step = {},
                                   StepKeeper* keeper = nullptr);
  double mean_distance_mm() const;  ///< of the last round's matches

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace phiz
