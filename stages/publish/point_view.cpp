#include <cmath>

#include "stages/publish/view_parts.h"

namespace phiz {
namespace {

constexpr int kPointSamples = 2;

// Squared distance from a few points, evenly spread over the cloud, to their nearest neighbours.
std::vector<float> probe_neighbours(const PointCloud& cloud) {
  constexpr std::size_t kProbes = 48;
  std::vector<float> nearest(std::min(kProbes, cloud.size()), std::numeric_limits<float>::infinity());
  parallel_for(nearest.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const Eigen::Vector3f probe = cloud.positions[k * cloud.size() / nearest.size()];
      float best = nearest[k];
      for (const Eigen::Vector3f& p : cloud.positions) {
        const float squared = (p - probe).squaredNorm();
        if (squared > 0 && squared < best) best = squared;
      }
      nearest[k] = best;
    }
  });
  std::erase_if(nearest, [](float squared) { return !std::isfinite(squared); });
  return nearest;
}

// Diameter of discs that cover randomly sampled points' surface but for a few of 10,000 places: seven times
// the median distance to the nearest neighbour.
float find_splat_size(const PointCloud& cloud) {
  constexpr float kCover = 7.0f;
  std::vector<float> squared = probe_neighbours(cloud);
  if (squared.empty()) return 1.0f;
  const auto middle = squared.begin() + static_cast<std::ptrdiff_t>(squared.size() / 2);
  std::nth_element(squared.begin(), middle, squared.end());
  return kCover * std::sqrt(*middle);
}

std::pair<int, int> find_rows(const Eigen::Vector3f& centre, float radius) {
  if (std::isnan(centre.y())) return {0, -1};
  return {static_cast<int>(std::floor(centre.y() - radius)),
          static_cast<int>(std::floor(centre.y() + radius))};
}

}  // namespace

Image render_points(const PointCloud& cloud, const ViewOptions& options) {
  check_heat(options, cloud.size());
  const Screen screen = make_screen(options, cloud.positions, {.samples = kPointSamples, .robust = true});
  const std::vector<Eigen::Vector3f> centres = project_all(screen, cloud.positions);
  const bool has_normals = cloud.size() > 0 && cloud.normals.size() == cloud.size();
  std::vector<Eigen::Vector3f> normals;
  if (has_normals) normals = turn_normals(screen, cloud.normals);
  const std::vector<Eigen::Vector3f> colours = find_colours(options, cloud.colours, cloud.size());
  const Eigen::Vector3f clay = decode_colour(options.clay);
  const float size_mm = options.point_size_mm > 0 ? options.point_size_mm : find_splat_size(cloud);
  const float radius =
      std::clamp(0.5f * size_mm * screen.samples_per_mm, 0.75f, static_cast<float>(screen.height));

  const BandBins bins(static_cast<int>(cloud.size()), screen.height, kBandPixels * kPointSamples,
                      [&](int i) { return find_rows(centres[i], radius); });
  PixelLayer layer = draw_bands(
      screen, bins, [&](std::int32_t i, SampleBand& band) { draw_disc(centres[i], radius, i, band); },
      [&](std::int32_t i, float, float) -> Eigen::Vector3f {
        const Eigen::Vector3f colour = colours.empty() ? clay : colours[i];
        if (!has_normals) return colour;
        const bool from_behind = normals[i].z() < 0;
        return light_surface(options, colour, from_behind ? Eigen::Vector3f(-normals[i]) : normals[i],
                             from_behind);
      });
  if (!has_normals && options.light != Light::kNone) {
    const int splat_pixels = static_cast<int>(std::ceil(std::min(2 * radius / kPointSamples, 10.0f)));
    light_by_relief(layer, options.light, options.heat.has_value(), std::clamp(splat_pixels + 1, 3, 7));
  }
  return finish_view(layer, options);
}

}  // namespace phiz
