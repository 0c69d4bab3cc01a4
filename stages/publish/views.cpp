#include "stages/publish/views.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "stages/publish/bitmap_font.h"
#include "stages/publish/colour_map.h"
#include "stages/publish/raster.h"
#include "stages/publish/screen.h"
#include "stages/publish/shading.h"

namespace phiz {
namespace {

constexpr int kBandPixels = 16;
constexpr int kBandRows = kBandPixels * kSamples;
constexpr std::size_t kGrain = 1 << 14;

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

std::vector<Eigen::Vector3f> average_normals(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3f> normals(mesh.vertex_count(), Eigen::Vector3f::Zero());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3f& a = mesh.positions[t.x()];
    const Eigen::Vector3f normal = (mesh.positions[t.y()] - a).cross(mesh.positions[t.z()] - a);
    if (!normal.allFinite()) continue;
    for (int corner = 0; corner < 3; ++corner) normals[t[corner]] += normal;
  }
  return normals;
}

std::vector<Eigen::Vector3f> turn_normals(const Screen& screen, std::vector<Eigen::Vector3f> normals) {
  parallel_for(normals.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const float length = std::sqrt(normals[i].squaredNorm());
      normals[i] =
          length > 0 ? Eigen::Vector3f(screen.rotation * normals[i] / length) : Eigen::Vector3f::UnitZ();
    }
  });
  return normals;
}

// Plain colour of each vertex or point in linear light; empty where all are clay.
std::vector<Eigen::Vector3f> find_colours(const ViewOptions& options,
                                          std::span<const std::array<std::uint8_t, 3>> own) {
  std::vector<Eigen::Vector3f> colours;
  if (options.heat) {
    const HeatMap& heat = *options.heat;
    const float range = heat.high > heat.low ? heat.high - heat.low : 1.0f;
    colours.reserve(heat.values.size());
    for (const float value : heat.values)
      colours.push_back(evaluate_colour_map(heat.map, (value - heat.low) / range));
  } else if (options.use_colours) {
    colours.reserve(own.size());
    for (const auto& colour : own) colours.push_back(decode_colour(colour));
  }
  return colours;
}

struct MeshScene {
  const TriangleMesh& mesh;
  const ViewOptions& options;
  std::vector<Eigen::Vector3f> corners;  ///< in samples
  std::vector<Eigen::Vector3f> normals;  ///< in the view
  std::vector<Eigen::Vector3f> colours;  ///< empty: clay
  Eigen::Vector3f clay;
};

struct Corners {
  Eigen::Vector3f a, b, c;
  float area;  ///< twice the area on the screen, > 0 where seen from outside
};

Corners find_corners(const MeshScene& scene, std::int32_t triangle_idx) {
  const Eigen::Vector3i& t = scene.mesh.triangles[triangle_idx];
  Corners corners{scene.corners[t.x()], scene.corners[t.y()], scene.corners[t.z()], 0};
  const Eigen::Vector3f u = corners.b - corners.a, v = corners.c - corners.a;
  corners.area = u.y() * v.x() - u.x() * v.y();
  return corners;
}

Eigen::Vector3f find_weights(const Corners& k, float x, float y) {
  const float bx = k.b.x() - x, by = k.b.y() - y, cx = k.c.x() - x, cy = k.c.y() - y, ax = k.a.x() - x,
              ay = k.a.y() - y;
  Eigen::Vector3f w(by * cx - bx * cy, cy * ax - cx * ay, ay * bx - ax * by);
  if (k.area < 0) w = -w;
  w = w.cwiseMax(0.0f);
  const float sum = w.sum();
  return sum > 0 ? Eigen::Vector3f(w / sum) : Eigen::Vector3f::Constant(1.0f / 3);
}

// How much of the line colour an edge of the triangle lays on this place. Lines grow fainter where triangles
// are smaller than a few pixels, so that dense parts stay readable.
float find_line_share(const Corners& k, const Eigen::Vector3f& weights) {
  constexpr float kHalfWidth = 0.55f * kSamples, kSoft = 0.5f * kSamples;
  const float area = std::abs(k.area);
  float share = 0;
  const auto add_edge = [&](const Eigen::Vector3f& p, const Eigen::Vector3f& q, float weight) {
    const float length = std::sqrt((q - p).head<2>().squaredNorm());
    if (length <= 0) return;
    const float height = area / length;
    const float cover = std::clamp((kHalfWidth + kSoft * 0.5f - weight * height) / kSoft, 0.0f, 1.0f);
    share = std::max(share, cover * std::clamp(height / (8.0f * kSamples), 0.12f, 0.9f));
  };
  add_edge(k.b, k.c, weights.x());
  add_edge(k.c, k.a, weights.y());
  add_edge(k.a, k.b, weights.z());
  return share;
}

Eigen::Vector3f shade_sample(const MeshScene& scene, std::int32_t triangle_idx, float x, float y) {
  const Eigen::Vector3i& t = scene.mesh.triangles[triangle_idx];
  const Corners corners = find_corners(scene, triangle_idx);
  const Eigen::Vector3f w = find_weights(corners, x, y);
  Eigen::Vector3f normal;
  if (scene.options.flat) {
    const Eigen::Vector3f u = corners.b - corners.a, v = corners.c - corners.a;
    normal = Eigen::Vector3f(u.z() * v.y() - u.y() * v.z(), u.z() * v.x() - u.x() * v.z(),
                             u.y() * v.x() - u.x() * v.y());
  } else {
    normal = scene.normals[t.x()] * w.x() + scene.normals[t.y()] * w.y() + scene.normals[t.z()] * w.z();
  }
  const bool from_behind = corners.area < 0;
  if (from_behind) normal = -normal;
  const float length = std::sqrt(normal.squaredNorm());
  normal = length > 0 ? Eigen::Vector3f(normal / length) : Eigen::Vector3f::UnitZ();
  Eigen::Vector3f albedo = scene.clay;
  if (!scene.colours.empty())
    albedo = scene.colours[t.x()] * w.x() + scene.colours[t.y()] * w.y() + scene.colours[t.z()] * w.z();
  if (from_behind && scene.options.light != Light::kNone)
    albedo = albedo.cwiseProduct(Eigen::Vector3f(0.42f, 0.28f, 0.62f));
  Eigen::Vector3f colour = shade(albedo, normal, scene.options.light);
  if (scene.options.wireframe) {
    const float share = find_line_share(corners, w);
    colour = colour * (1 - share) + Eigen::Vector3f(0.012f, 0.022f, 0.06f) * share;
  }
  return colour;
}

// Averages the samples of each pixel of a band into the layer.
template <class ShadeSample>
void resolve_band(const SampleBand& band, PixelLayer& layer, const ShadeSample& shade_at) {
  constexpr float kShare = 1.0f / (kSamples * kSamples);
  for (int y = band.first_row / kSamples; y < (band.first_row + band.rows) / kSamples; ++y)
    for (int x = 0; x < layer.width; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * layer.width + x;
      int covered = 0;
      float nearest = -std::numeric_limits<float>::infinity();
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (int s = 0; s < kSamples * kSamples; ++s) {
        const int u = x * kSamples + s % kSamples, v = y * kSamples + s / kSamples;
        const std::size_t sample = static_cast<std::size_t>(v - band.first_row) * band.width + u;
        if (band.owner[sample] == SampleBand::kNothing) continue;
        ++covered;
        nearest = std::max(nearest, band.depth[sample]);
        sum += shade_at(band.owner[sample], static_cast<float>(u) + 0.5f, static_cast<float>(v) + 0.5f);
      }
      if (covered == 0) continue;
      layer.colour[i] = sum * kShare;
      layer.coverage[i] = static_cast<float>(covered) * kShare;
      layer.depth[i] = nearest / kSamples;
    }
}

// Draws all bands: each thread has a band of its own, and the bands are the same at any thread count.
template <class Draw, class ShadeSample>
PixelLayer draw_bands(const Screen& screen, const BandBins& bins, const Draw& draw,
                      const ShadeSample& shade_at) {
  PixelLayer layer(screen.width / kSamples, screen.height / kSamples);
  parallel_for(static_cast<std::size_t>(bins.band_count()), 1, [&](std::size_t begin, std::size_t end) {
    SampleBand band;
    for (std::size_t b = begin; b < end; ++b) {
      const int first = static_cast<int>(b) * kBandRows;
      band.reset(screen.width, first, std::min(kBandRows, screen.height - first));
      for (const std::int32_t primitive : bins.primitives(static_cast<int>(b))) draw(primitive, band);
      resolve_band(band, layer, shade_at);
    }
  });
  return layer;
}

void write_label_and_legend(Image& image, const ViewOptions& options) {
  if (options.heat) draw_legend(image, *options.heat);
  if (!options.label.empty()) draw_text(image, 10, 10, options.label, {});
}

// Diameter at which randomly sampled points cover the surface: a few times the usual distance to the nearest
// neighbour.
float find_splat_size(const PointCloud& cloud) {
  constexpr std::size_t kProbes = 96;
  constexpr float kCover = 7.0f;
  const std::size_t stride = std::max<std::size_t>(1, cloud.size() / kProbes);
  std::vector<float> nearest;
  for (std::size_t i = 0; i < cloud.size(); i += stride) {
    float best = std::numeric_limits<float>::infinity();
    for (const Eigen::Vector3f& p : cloud.positions) {
      const float squared = (p - cloud.positions[i]).squaredNorm();
      if (squared > 0 && squared < best) best = squared;
    }
    if (best < std::numeric_limits<float>::infinity()) nearest.push_back(best);
  }
  if (nearest.empty()) return 1.0f;
  std::nth_element(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() / 2),
                   nearest.end());
  return kCover * std::sqrt(nearest[nearest.size() / 2]);
}

}  // namespace

Image render_mesh(const TriangleMesh& mesh, const ViewOptions& options) {
  check_heat(options, mesh.vertex_count());
  const auto count = static_cast<int>(mesh.vertex_count());
  for (const Eigen::Vector3i& t : mesh.triangles)
    if (t.minCoeff() < 0 || t.maxCoeff() >= count)
      throw InvalidInput("triangle with a vertex index out of range");
  const Screen screen = make_screen(options, mesh.positions, false);
  MeshScene scene{mesh,
                  options,
                  project_all(screen, mesh.positions),
                  {},
                  find_colours(options, mesh.colours),
                  decode_colour(options.clay)};
  if (!options.flat)
    scene.normals = turn_normals(
        screen, mesh.normals.size() == mesh.vertex_count() ? mesh.normals : average_normals(mesh));
  if (scene.colours.size() != mesh.vertex_count()) scene.colours.clear();

  const BandBins bins(static_cast<int>(mesh.triangle_count()), screen.height, kBandRows, [&](int i) {
    const Eigen::Vector3i& t = mesh.triangles[i];
    const float a = scene.corners[t.x()].y(), b = scene.corners[t.y()].y(), c = scene.corners[t.z()].y();
    if (std::isnan(a + b + c)) return std::pair(0, -1);
    return std::pair(static_cast<int>(std::floor(std::min({a, b, c}))),
                     static_cast<int>(std::floor(std::max({a, b, c}))));
  });
  PixelLayer layer = draw_bands(
      screen, bins,
      [&](std::int32_t i, SampleBand& band) {
        const Eigen::Vector3i& t = mesh.triangles[i];
        draw_triangle(scene.corners[t.x()], scene.corners[t.y()], scene.corners[t.z()], i, band);
      },
      [&](std::int32_t i, float x, float y) { return shade_sample(scene, i, x, y); });
  if (options.light == Light::kSoft) darken_creases(layer, static_cast<float>(options.height) / 40.0f);
  Image image = compose(layer, options.background);
  write_label_and_legend(image, options);
  return image;
}

Image render_points(const PointCloud& cloud, const ViewOptions& options) {
  check_heat(options, cloud.size());
  const Screen screen = make_screen(options, cloud.positions, true);
  const std::vector<Eigen::Vector3f> centres = project_all(screen, cloud.positions);
  const bool has_normals = cloud.normals.size() == cloud.size();
  std::vector<Eigen::Vector3f> normals;
  if (has_normals) normals = turn_normals(screen, cloud.normals);
  std::vector<Eigen::Vector3f> colours = find_colours(options, cloud.colours);
  if (colours.size() != cloud.size()) colours.clear();
  const Eigen::Vector3f clay = decode_colour(options.clay);
  const float size_mm = options.point_size_mm > 0 ? options.point_size_mm : find_splat_size(cloud);
  const float radius = std::max(0.5f * size_mm * screen.samples_per_mm, 0.75f);

  const BandBins bins(static_cast<int>(cloud.size()), screen.height, kBandRows, [&](int i) {
    if (std::isnan(centres[i].y())) return std::pair(0, -1);
    return std::pair(static_cast<int>(std::floor(centres[i].y() - radius)),
                     static_cast<int>(std::floor(centres[i].y() + radius)));
  });
  PixelLayer layer = draw_bands(
      screen, bins, [&](std::int32_t i, SampleBand& band) { draw_disc(centres[i], radius, i, band); },
      [&](std::int32_t i, float, float) {
        const Eigen::Vector3f albedo = colours.empty() ? clay : colours[i];
        if (!has_normals) return albedo;
        const bool from_behind = normals[i].z() < 0;
        if (!from_behind) return shade(albedo, normals[i], options.light);
        return shade(albedo.cwiseProduct(Eigen::Vector3f(0.42f, 0.28f, 0.62f)), -normals[i], options.light);
      });
  const int splat_pixels = static_cast<int>(std::ceil(2 * radius / kSamples));
  if (!has_normals && options.light != Light::kNone)
    light_by_relief(layer, options.light, std::clamp(splat_pixels + 1, 3, 7));
  if (options.light == Light::kSoft) darken_creases(layer, static_cast<float>(options.height) / 40.0f);
  Image image = compose(layer, options.background);
  write_label_and_legend(image, options);
  return image;
}

}  // namespace phiz
