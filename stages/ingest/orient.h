#pragma once

#include "formats/point_cloud.h"

namespace phiz {

struct NormalEstimate {
  double noise_mm = 0;         ///< median distance of a point to the plane of its neighbours
  double density_per_mm2 = 0;  ///< median number of points a square millimetre of surface
};

/// Fills `normals` and `confidences` of a cloud in mm from its positions. A normal is that of the plane through all
/// points within `radius_mm` (doubled where there are fewer than ten), turned to the side from which more rays
/// escape the cloud: a head is seen from outside, and the two faces of an ear hide each other's inner sides.
/// Confidence falls with the scatter about the plane. O(N k). Deterministic.
NormalEstimate estimate_normals(PointCloud& cloud, float radius_mm);

}  // namespace phiz
