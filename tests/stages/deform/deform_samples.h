#pragma once

#include "formats/deformation.h"
#include "stages/deform/deform.h"

namespace phiz::test {

/// A smooth image that is zero outside a disk of the square; `peak` in the middle.
FieldImage make_bump(int channels, int side, const Eigen::Vector2d& centre, double radius,
                     const Eigen::Vector3d& peak);

/// A cascade of every type: neutral, two adds, a local add, a jaw that turns all of that, lips that blend
/// with what was before the jaw, and a constant far away. Parameters smile, raise, open, close, mix.
Deformation make_sample_deformation(int side = 33);

/// Points scattered over the square on a curved sheet, with frames that differ from place to place.
NeutralSurface make_sample_surface(int count);

std::vector<double> draw_parameters(const Deformation& deformation);

}  // namespace phiz::test
