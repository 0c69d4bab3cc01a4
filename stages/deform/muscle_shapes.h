#pragma once

#include "formats/muscle_file.h"
#include "stages/deform/uv_canvas.h"

namespace phiz {

/// A muscle's vectors (mm) or mask (x) at every node of the canvas, masks applied. Throws InvalidInput for
/// landmarks and regions the head does not have.
std::vector<Eigen::Vector3d> draw_muscle(const ControlMesh& generic_head, const UvCanvas& canvas,
                                         const MuscleFile& muscle);

/// 1 up to the plateau, then down to 0 at 1 without a corner; strictly monotone in between.
double falloff(double radius, double plateau);

}  // namespace phiz
