#pragma once

#include <Eigen/Core>

#include "stages/publish/views.h"

namespace phiz {

/// Linear-light colour (square of the encoded one) at t in [0,1], clamped; NaN is grey.
Eigen::Vector3f evaluate_colour_map(ColourMap map, float t);

/// Draws the bar with five numbers and the caption into the right edge of the picture.
void draw_legend(Image& image, const HeatMap& heat);

}  // namespace phiz
