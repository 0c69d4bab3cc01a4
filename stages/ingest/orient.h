#pragma once

#include "formats/point_cloud.h"

namespace phiz {

struct NormalEstimate {
  double noise_mm = 0;         ///< median distance of a point to the plane of its neighbours
  double density_per_mm2 = 0;  ///< median number of points a square millimetre of surface
};

/// Oriented samples of a surface near the cloud (the generic head in its pose): they decide where sight does
/// not.
struct OrientationGuide {
  std::vector<Eigen::Vector3f> positions, normals;
};

/// Fills `normals` and `confidences` of a cloud in mm from its positions. A normal is that of the plane
/// through all points within `radius_mm` (doubled where there are fewer than ten), turned outward
/// (outward.h). Confidence falls with the scatter about
/// the plane. O(N k). Deterministic.
NormalEstimate estimate_normals(PointCloud& cloud, float radius_mm, const OrientationGuide& guide);

}  // namespace phiz
