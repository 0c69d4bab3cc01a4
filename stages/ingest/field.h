#pragma once

#include "formats/distance_field.h"
#include "formats/point_cloud.h"

namespace phiz {

/// Truncated signed distance to the local planes of an oriented cloud in mm, on the lattice cells within
/// three cells of a point (Hoppe et al. 1992, with a weighted mean of the planes in reach). Confidence is the
/// mean confidence of the points that decided a sample, falling with their distance. O(cells in the band).
/// Deterministic.
DistanceField compute_distance_field(const PointCloud& cloud, double voxel_mm);

}  // namespace phiz
