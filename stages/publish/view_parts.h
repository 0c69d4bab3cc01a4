#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <vector>

#include "stages/geometry/parallel.h"
#include "stages/publish/raster.h"
#include "stages/publish/screen.h"
#include "stages/publish/shading.h"
#include "stages/publish/views.h"

namespace phiz {

inline constexpr int kBandPixels = 16;  ///< pixel rows that one thread draws at a time

void check_heat(const ViewOptions& options, std::size_t count);

/// In samples; NaN where the position is not finite or too far off.
std::vector<Eigen::Vector3f> project_all(const Screen& screen, std::span<const Eigen::Vector3f> positions);

/// Unit normals in the view's frame.
std::vector<Eigen::Vector3f> turn_normals(const Screen& screen, std::span<const Eigen::Vector3f> normals);

/// Plain colour of each vertex or point in linear light; empty where all are clay.
std::vector<Eigen::Vector3f> find_colours(const ViewOptions& options,
                                          std::span<const std::array<std::uint8_t, 3>> own,
                                          std::size_t count);

/// Light on a surface of this plain colour; violet where it is seen from behind (`normal` faces the viewer).
Eigen::Vector3f light_surface(const ViewOptions& options, Eigen::Vector3f colour,
                              const Eigen::Vector3f& normal, bool from_behind);

/// Creases, background, label and legend.
Image finish_view(PixelLayer& layer, const ViewOptions& options);

/// Averages the samples of each pixel of a band into the layer.
template <class ShadeSample>
void resolve_band(const SampleBand& band, int samples, PixelLayer& layer, const ShadeSample& shade_at) {
  const float share = 1.0f / static_cast<float>(samples * samples);
  for (int y = band.first_row / samples; y < (band.first_row + band.rows) / samples; ++y)
    for (int x = 0; x < layer.width; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * layer.width + x;
      int covered = 0;
      float nearest = -std::numeric_limits<float>::infinity();
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (int s = 0; s < samples * samples; ++s) {
        const int u = x * samples + s % samples, v = y * samples + s / samples;
        const std::size_t sample = static_cast<std::size_t>(v - band.first_row) * band.width + u;
        if (band.owner[sample] == SampleBand::kNothing) continue;
        ++covered;
        nearest = std::max(nearest, band.depth[sample]);
        sum += shade_at(band.owner[sample], static_cast<float>(u) + 0.5f, static_cast<float>(v) + 0.5f);
      }
      if (covered == 0) continue;
      layer.colour[i] = sum * share;
      layer.coverage[i] = static_cast<float>(covered) * share;
      layer.depth[i] = nearest / static_cast<float>(samples);
    }
}

/// Draws all bands: draw(primitive, band) for each primitive in order, then shade_at(primitive, x, y) for
/// each covered sample. A thread has a band of its own, and the bands are the same at any thread count.
template <class Draw, class ShadeSample>
PixelLayer draw_bands(const Screen& screen, const BandBins& bins, const Draw& draw,
                      const ShadeSample& shade_at) {
  PixelLayer layer(screen.width / screen.samples, screen.height / screen.samples);
  const int band_rows = kBandPixels * screen.samples;
  parallel_for(static_cast<std::size_t>(bins.band_count()), 1, [&](std::size_t begin, std::size_t end) {
    SampleBand band;
    for (std::size_t b = begin; b < end; ++b) {
      const int first = static_cast<int>(b) * band_rows;
      band.reset(screen.width, first, std::min(band_rows, screen.height - first));
      for (const std::int32_t primitive : bins.primitives(static_cast<int>(b))) draw(primitive, band);
      resolve_band(band, screen.samples, layer, shade_at);
    }
  });
  return layer;
}

}  // namespace phiz
