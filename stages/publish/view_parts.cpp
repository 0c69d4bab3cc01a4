#include "stages/publish/view_parts.h"

#include <cmath>
#include <string>

#include "stages/geometry/error.h"
#include "stages/publish/bitmap_font.h"
#include "stages/publish/colour_map.h"

namespace phiz {
namespace {

constexpr std::size_t kGrain = 1 << 14;

}  // namespace

void check_heat(const ViewOptions& options, std::size_t count) {
  if (options.heat && options.heat->values.size() != count)
    throw InvalidInput("heat map of " + std::to_string(options.heat->values.size()) + " values for " +
                       std::to_string(count) + " vertices or points");
}

std::vector<Eigen::Vector3f> project_all(const Screen& screen, std::span<const Eigen::Vector3f> positions) {
  std::vector<Eigen::Vector3f> projected(positions.size());
  parallel_for(positions.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      projected[i] = screen.project(positions[i]);
      if (!(projected[i].cwiseAbs().maxCoeff() < kFarthest))
        projected[i].setConstant(std::numeric_limits<float>::quiet_NaN());
    }
  });
  return projected;
}

std::vector<Eigen::Vector3f> turn_normals(const Screen& screen, std::span<const Eigen::Vector3f> normals) {
  std::vector<Eigen::Vector3f> turned(normals.size());
  parallel_for(normals.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const float length = std::sqrt(normals[i].squaredNorm());
      if (length > 0) {
        turned[i] = screen.rotation * normals[i] / length;
      } else {
        turned[i] = Eigen::Vector3f::UnitZ();
      }
    }
  });
  return turned;
}

std::vector<Eigen::Vector3f> find_colours(const ViewOptions& options,
                                          std::span<const std::array<std::uint8_t, 3>> own,
                                          std::size_t count) {
  std::vector<Eigen::Vector3f> colours;
  if (options.heat) {
    const HeatMap& heat = *options.heat;
    const float range = heat.high > heat.low ? heat.high - heat.low : 1.0f;
    colours.reserve(count);
    for (const float value : heat.values)
      colours.push_back(evaluate_colour_map(heat.map, (value - heat.low) / range));
  } else if (options.use_colours && own.size() == count) {
    colours.reserve(count);
    for (const auto& colour : own) colours.push_back(decode_colour(colour));
  }
  return colours;
}

Eigen::Vector3f light_surface(const ViewOptions& options, Eigen::Vector3f colour,
                              const Eigen::Vector3f& normal, bool from_behind) {
  if (from_behind && options.light != Light::kNone)
    colour = colour.cwiseProduct(Eigen::Vector3f(0.42f, 0.28f, 0.62f));
  return options.heat ? shade_measured(colour, normal, options.light) : shade(colour, normal, options.light);
}

Image finish_view(PixelLayer& layer, const ViewOptions& options) {
  constexpr float kStrength = 2.2f, kMeasuredStrength = 0.8f;
  if (options.light == Light::kSoft)
    darken_creases(layer, static_cast<float>(options.height) / 40.0f,
                   options.heat ? kMeasuredStrength : kStrength);
  Image image = compose(layer, options.background);
  if (!options.label.empty()) draw_text(image, 10, 10, options.label, {});
  return options.heat ? append_legend(image, *options.heat, options.background) : image;
}

}  // namespace phiz
