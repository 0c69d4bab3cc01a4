#pragma once

#include <vector>

#include "stages/geometry/point_grid.h"
#include "stages/ingest/orient.h"

namespace phiz {

/// Turns normals (unit, by the index of the grid's points, signs arbitrary) to the outside. The points of a
/// cell with like normals are a sheet; a sheet's evidence is from which side more rays escape the cloud, and
/// the guide; sheets that continue each other agree, as they believe more and more in what all round them
/// believe: so the hollow of an ear, where sight says nothing, follows its rim. O(points + sheets x rays).
/// Deterministic.
void turn_outward(const PointGrid& coarse, const OrientationGuide& guide,
                  std::vector<Eigen::Vector3f>& normals);

}  // namespace phiz
