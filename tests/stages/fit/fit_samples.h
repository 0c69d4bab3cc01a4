#pragma once

#include "stages/fit/fit.h"
#include "tests/stages/synth/synth_samples.h"

namespace phiz::test {

/// The generic head, read once a run.
const ControlMesh& generic_head();
const SubdivisionHierarchy& generic_hierarchy();  ///< two levels

/// `count` points by area on the surface of level 2 over `control`, with the normals of the triangles.
PointCloud sample_surface(const ControlPositions& control, int count);

/// Triangles that are turned by more than 90 degrees from `b` to `a`.
int count_folds(const ControlPositions& a, const ControlPositions& b);

double mean_distance(const ControlPositions& a, const ControlPositions& b);

/// Mean distance of the vertices of level 2 over `control` to the surface of level 2 over `truth`.
double mean_surface_error(const ControlPositions& control, const ControlPositions& truth);

}  // namespace phiz::test
