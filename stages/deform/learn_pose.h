#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "stages/geometry/scan_surface.h"

namespace phiz {

/// Places of the neutral head that an expression moves little or not at all.
struct StillPlaces {
  std::vector<Eigen::Vector3d> positions, normals;
  std::vector<double> weights;  ///< 0: not used
};

/// The rigid motion that brings the places onto the scan: point to plane with Geman-McClure weights whose
/// scale falls from 5 mm to 0.35 mm, so that what the expression moves drops out. `start` within some 15 mm
/// and 10 degrees. Throws InvalidInput where too few places find the scan. Deterministic.
Eigen::Isometry3d find_rigid_motion(const ScanSurface& scan, const StillPlaces& places,
                                    const Eigen::Isometry3d& start = Eigen::Isometry3d::Identity());

/// The rigid motion hidden in a displacement field: the least squares one over what moves alike, robust
/// (scale 0.3 mm). Moving places by its inverse takes it out exactly where all of them moved rigidly.
Eigen::Isometry3d find_common_motion(const std::vector<Eigen::Vector3d>& from,
                                     const std::vector<Eigen::Vector3d>& to,
                                     const std::vector<double>& weights);

}  // namespace phiz
