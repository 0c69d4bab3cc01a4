#pragma once

#include <Eigen/Core>
#include <vector>

#include "stages/publish/views.h"

namespace phiz {

/// What the samples of each pixel amount to, before composition.
struct PixelLayer {
  int width = 0, height = 0;
  std::vector<Eigen::Vector3f> colour;  ///< linear light, already multiplied by coverage
  std::vector<float> coverage;          ///< [0,1]
  std::vector<float> depth;  ///< nearest sample of the pixel, in pixels; where coverage is 0 meaningless

  PixelLayer(int width_pixels, int height_pixels);
};

Eigen::Vector3f decode_colour(const std::array<std::uint8_t, 3>& colour);  ///< to linear light

/// Light that a surface of this colour and view-space unit normal (z towards the viewer) sends to the viewer.
Eigen::Vector3f shade(const Eigen::Vector3f& albedo, const Eigen::Vector3f& normal, Light light);

/// The same for colours that carry a quantity: lightness varies little and no highlight is added, so that
/// they can be compared with the legend.
Eigen::Vector3f shade_measured(const Eigen::Vector3f& colour, const Eigen::Vector3f& normal, Light light);

/// Lights a layer that holds plain colours by normals from planes fitted to its depth within `radius` pixels.
void light_by_relief(PixelLayer& layer, Light light, bool measured, int radius);

/// Darkens creases: each pixel by the share of its surroundings (within `radius` pixels) that stands in front
/// of it.
void darken_creases(PixelLayer& layer, float radius, float strength);

Image compose(const PixelLayer& layer, const std::array<std::uint8_t, 3>& background);

}  // namespace phiz
