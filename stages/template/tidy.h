#pragma once

#include <Eigen/Core>
#include <vector>

#include "formats/control_mesh.h"

namespace phiz {

/// Positions have six decimals in files: numbers on that grain survive one unchanged.
double on_grain(double x);

/// Every vertex and its image (Annotations::mirror) to the mean of the two, exactly mirrored and on the
/// grain; those that are their own image to x = 0.
void make_symmetric(ControlMesh& mesh);

/// Takes back part of the change since `start`, again and again, at the vertices of triangles whose smallest
/// angle is below `min_angle_deg`, both sides alike. Whether none is left.
bool hold_back_sharp_triangles(ControlMesh& mesh, const std::vector<Eigen::Vector3d>& start,
                               double min_angle_deg);

/// Moves vertices of triangles whose smallest angle is below `min_angle_deg` along the surface, by little,
/// both sides alike, until it is not or nothing helps.
void widen_sharp_triangles(ControlMesh& mesh, double min_angle_deg);

}  // namespace phiz
