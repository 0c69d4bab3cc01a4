#pragma once

#include <Eigen/Core>

#include "stages/publish/views.h"

namespace phiz {

/// Linear-light colour (square of the encoded one) at t in [0,1], clamped; NaN is grey.
Eigen::Vector3f evaluate_colour_map(ColourMap map, float t);

/// The picture with a strip on its right that holds the caption, the bar and five numbers.
Image append_legend(const Image& picture, const HeatMap& heat, const std::array<std::uint8_t, 3>& background);

}  // namespace phiz
