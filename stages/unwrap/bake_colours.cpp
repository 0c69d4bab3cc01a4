#include <array>
#include <cmath>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "stages/geometry/point_grid.h"
#include "stages/unwrap/unwrap.h"

namespace phiz {
namespace {

constexpr std::size_t kGrain = 2048;

/// A level of the pyramid: colours and how much is known of each.
struct Layer {
  int width = 0, height = 0;
  std::vector<Eigen::Vector3f> colours;
  std::vector<float> weights;
};

Layer reduce(const Layer& fine) {
  Layer coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}, {}};
  coarse.colours.assign(static_cast<std::size_t>(coarse.width) * coarse.height, Eigen::Vector3f::Zero());
  coarse.weights.assign(coarse.colours.size(), 0);
  for (int y = 0; y < fine.height; ++y) {
    for (int x = 0; x < fine.width; ++x) {
      const std::size_t from = static_cast<std::size_t>(y) * fine.width + x,
                        to = static_cast<std::size_t>(y / 2) * coarse.width + x / 2;
      coarse.colours[to] += fine.weights[from] * fine.colours[from];
      coarse.weights[to] += fine.weights[from];
    }
  }
  for (std::size_t i = 0; i < coarse.colours.size(); ++i) {
    if (coarse.weights[i] > 0) coarse.colours[i] /= coarse.weights[i];
    coarse.weights[i] = std::min(1.0f, coarse.weights[i]);
  }
  return coarse;
}

/// Gives what is unknown the colour that the coarser layer, interpolated, has there.
void fill_from(const Layer& coarse, Layer& fine) {
  for (int y = 0; y < fine.height; ++y) {
    for (int x = 0; x < fine.width; ++x) {
      const std::size_t at = static_cast<std::size_t>(y) * fine.width + x;
      if (fine.weights[at] > 0) continue;
      const float px = std::max(0.0f, 0.5f * (x - 0.5f)), py = std::max(0.0f, 0.5f * (y - 0.5f));
      const int x0 = static_cast<int>(px), y0 = static_cast<int>(py);
      const int x1 = std::min(x0 + 1, coarse.width - 1), y1 = std::min(y0 + 1, coarse.height - 1);
      const auto colour = [&](int cx, int cy) -> const Eigen::Vector3f& {
        return coarse.colours[static_cast<std::size_t>(cy) * coarse.width + cx];
      };
      const float fx = px - x0, fy = py - y0;
      fine.colours[at] = (1 - fy) * ((1 - fx) * colour(x0, y0) + fx * colour(x1, y0)) +
                         fy * ((1 - fx) * colour(x0, y1) + fx * colour(x1, y1));
    }
  }
}

void fill_unknown(Layer& layer) {
  if (layer.width <= 1 && layer.height <= 1) return;
  Layer coarse = reduce(layer);
  fill_unknown(coarse);
  fill_from(coarse, layer);
}

}  // namespace

BakedColours bake_colours(const PointCloud& cloud, std::span<const Eigen::Vector3f> positions,
                          std::span<const Eigen::Vector3f> normals, int width, int height,
                          const ColourOptions& options) {
  CONTRACT(positions.size() == normals.size() &&
           static_cast<std::size_t>(width) * height == positions.size());
  if (!cloud.has_colours() || !cloud.has_normals())
    throw InvalidInput("the cloud has no colours or no normals");
  if (!(options.reach_mm > 0 && options.spread_mm > 0))
    throw InvalidInput("reach and spread must be above 0");
  std::array<float, 256> linear;
  for (int i = 0; i < 256; ++i) linear[i] = linear_from_srgb(static_cast<std::uint8_t>(i));
  const PointGrid grid(cloud.positions, static_cast<float>(options.reach_mm));
  const float falloff = static_cast<float>(-0.5 / (options.spread_mm * options.spread_mm));

  Layer layer{width, height, {}, {}};
  layer.colours.assign(positions.size(), Eigen::Vector3f::Zero());
  layer.weights.assign(positions.size(), 0);
  parallel_for(positions.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      float weight_sum = 0;
      grid.for_each_within(positions[i], static_cast<float>(options.reach_mm), [&](int slot, float d2) {
        const int point = grid.order()[slot];
        const float facing = normals[i].dot(cloud.normals[point]);
        if (facing <= 0) return;
        const float known = cloud.has_confidences() ? 0.01f + cloud.confidences[point] : 1.0f;
        const float weight = facing * facing * known * std::exp(falloff * d2);
        const auto& rgb = cloud.colours[point];
        sum += weight * Eigen::Vector3f(linear[rgb[0]], linear[rgb[1]], linear[rgb[2]]);
        weight_sum += weight;
      });
      if (!(weight_sum > 1e-12f)) continue;
      layer.colours[i] = sum / weight_sum;
      layer.weights[i] = 1;
    }
  });
  BakedColours baked;
  baked.mask = layer.weights;
  fill_unknown(layer);
  baked.colours = std::move(layer.colours);
  for (Eigen::Vector3f& colour : baked.colours) colour = colour.cwiseMax(0.0f).cwiseMin(1.0f);
  return baked;
}

}  // namespace phiz
