#include "stages/publish/shading.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

constexpr std::size_t kRowsPerChunk = 16;

float power_of_two_times(float x, int doublings) {
  for (int k = 0; k < doublings; ++k) x *= x;
  return x;
}

// Plane through the depths around (x, y), by least squares; samples farther than `reach` in depth belong to
// other surfaces and do not count.
Eigen::Vector3f fit_normal(const PixelLayer& layer, int x, int y, int radius, float reach) {
  const std::size_t here = static_cast<std::size_t>(y) * layer.width + x;
  float sxx = 1e-3f, sxy = 0, syy = 1e-3f, sx = 0, sy = 0, sz = 0, sxz = 0, syz = 0, count = 0;
  for (int dy = -radius; dy <= radius; ++dy)
    for (int dx = -radius; dx <= radius; ++dx) {
      if (dx * dx + dy * dy > radius * radius || x + dx < 0 || x + dx >= layer.width || y + dy < 0 ||
          y + dy >= layer.height)
        continue;
      const std::size_t there = here + static_cast<std::ptrdiff_t>(dy) * layer.width + dx;
      const float dz = layer.depth[there] - layer.depth[here];
      if (layer.coverage[there] == 0 || std::abs(dz) > reach) continue;
      const auto fx = static_cast<float>(dx), fy = static_cast<float>(dy);
      count += 1, sx += fx, sy += fy, sz += dz, sxx += fx * fx, sxy += fx * fy, syy += fy * fy,
          sxz += fx * dz, syz += fy * dz;
    }
  const float inverse = 1.0f / count;
  const float a = sxx - sx * sx * inverse, b = sxy - sx * sy * inverse, c = syy - sy * sy * inverse;
  const float d = sxz - sx * sz * inverse, e = syz - sy * sz * inverse;
  const float determinant = a * c - b * b;
  if (determinant < 1e-6f) return Eigen::Vector3f::UnitZ();
  const float gx = (d * c - e * b) / determinant, gy = (a * e - b * d) / determinant;
  const Eigen::Vector3f normal(-gx, gy, 1.0f);  // rows run down, the view's y up
  return normal / std::sqrt(normal.squaredNorm());
}

struct Offset {
  int x, y;
  float inverse_length;
};

// Points of a sunflower spiral (golden angle, by repeated rotation: no library functions).
std::vector<Offset> make_spiral(float radius) {
  constexpr int kCount = 40;
  constexpr float kCosine = -0.7373688f, kSine = 0.6754903f;
  std::vector<Offset> offsets;
  float c = 1, s = 0;
  for (int k = 0; k < kCount; ++k) {
    const float r = std::max(1.0f, radius * std::sqrt((static_cast<float>(k) + 0.5f) / kCount));
    offsets.push_back({static_cast<int>(std::lround(r * c)), static_cast<int>(std::lround(r * s)), 1.0f / r});
    const float next = c * kCosine - s * kSine;
    s = s * kCosine + c * kSine;
    c = next;
  }
  return offsets;
}

float find_occlusion(const PixelLayer& layer, int x, int y, const std::vector<Offset>& offsets,
                     float radius) {
  const std::size_t here = static_cast<std::size_t>(y) * layer.width + x;
  float sum = 0;
  for (const Offset& offset : offsets) {
    const int u = x + offset.x, v = y + offset.y, mirrored_u = x - offset.x, mirrored_v = y - offset.y;
    if (std::min({u, v, mirrored_u, mirrored_v}) < 0 || std::max(u, mirrored_u) >= layer.width ||
        std::max(v, mirrored_v) >= layer.height)
      continue;
    const std::size_t there = static_cast<std::size_t>(v) * layer.width + u;
    const std::size_t mirrored = static_cast<std::size_t>(mirrored_v) * layer.width + mirrored_u;
    if (layer.coverage[there] == 0 || layer.coverage[mirrored] == 0) continue;
    const float reach = 2 * radius;
    // Both ends together, so that a slope does not count: only hollows do.
    const float rise = std::clamp(layer.depth[there] - layer.depth[here], -reach, reach) +
                       std::clamp(layer.depth[mirrored] - layer.depth[here], -reach, reach);
    sum += std::clamp(rise * offset.inverse_length * 0.5f, 0.0f, 1.0f);
  }
  return sum / static_cast<float>(offsets.size());
}

}  // namespace

PixelLayer::PixelLayer(int width_pixels, int height_pixels)
    : width(width_pixels),
      height(height_pixels),
      colour(static_cast<std::size_t>(width) * height, Eigen::Vector3f::Zero()),
      coverage(colour.size(), 0.0f),
      depth(colour.size(), 0.0f) {}

Eigen::Vector3f decode_colour(const std::array<std::uint8_t, 3>& colour) {
  const Eigen::Vector3f v(colour[0], colour[1], colour[2]);
  return (v / 255.0f).cwiseAbs2();
}

Eigen::Vector3f shade(const Eigen::Vector3f& albedo, const Eigen::Vector3f& normal, Light light) {
  if (light == Light::kNone) return albedo;
  if (light == Light::kSide) {
    // A strong light from the left and a weak bluish one from the right, both grazing a face seen from the
    // front.
    const Eigen::Vector3f left(-0.9250f, 0.1900f, 0.3290f), right(0.9250f, 0.1900f, 0.3290f);
    const Eigen::Vector3f counter = Eigen::Vector3f(0.24f, 0.30f, 0.40f) * std::max(normal.dot(right), 0.0f);
    return albedo.cwiseProduct(Eigen::Vector3f::Constant(0.03f + 1.15f * std::max(normal.dot(left), 0.0f)) +
                               counter);
  }
  const Eigen::Vector3f key(-0.4575f, 0.5490f, 0.6995f), fill(0.6667f, 0.0667f, 0.7424f);
  const float wrapped = std::max((normal.dot(key) + 0.2f) / 1.2f, 0.0f);
  const float filled = std::max(normal.dot(fill), 0.0f);
  const float grazing = 1.0f - std::clamp(normal.z(), 0.0f, 1.0f);
  const float rim = 0.22f * grazing * grazing * grazing * std::max(0.4f + 0.6f * normal.y(), 0.0f);
  const Eigen::Vector3f between = key + Eigen::Vector3f::UnitZ();
  const float shine = std::max(normal.dot(between) / std::sqrt(between.squaredNorm()), 0.0f);
  const float highlight = 0.07f * power_of_two_times(shine, 5);
  const float diffuse = 0.13f + 0.05f * normal.y() + 0.78f * wrapped + 0.14f * filled;
  return albedo * (diffuse + rim) + Eigen::Vector3f::Constant(highlight);
}

Eigen::Vector3f shade_measured(const Eigen::Vector3f& colour, const Eigen::Vector3f& normal, Light light) {
  if (light == Light::kNone) return colour;
  const float brightness = shade(Eigen::Vector3f::Ones(), normal, light).y();
  return colour * (0.45f + 0.55f * std::min(brightness, 1.0f));
}

void light_by_relief(PixelLayer& layer, Light light, bool measured, int radius) {
  const float reach = 2.5f * static_cast<float>(radius);
  parallel_for(static_cast<std::size_t>(layer.height), kRowsPerChunk,
               [&](std::size_t begin, std::size_t end) {
                 for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
                   for (int x = 0; x < layer.width; ++x) {
                     const std::size_t i = static_cast<std::size_t>(y) * layer.width + x;
                     if (layer.coverage[i] == 0) continue;
                     const Eigen::Vector3f normal = fit_normal(layer, x, y, radius, reach);
                     const Eigen::Vector3f colour = layer.colour[i] / layer.coverage[i];
                     layer.colour[i] =
                         (measured ? shade_measured(colour, normal, light) : shade(colour, normal, light)) *
                         layer.coverage[i];
                   }
               });
}

void darken_creases(PixelLayer& layer, float radius, float strength) {
  const std::vector<Offset> offsets = make_spiral(radius);
  parallel_for(
      static_cast<std::size_t>(layer.height), kRowsPerChunk, [&](std::size_t begin, std::size_t end) {
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
          for (int x = 0; x < layer.width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * layer.width + x;
            if (layer.coverage[i] == 0) continue;
            layer.colour[i] *= 1.0f / (1.0f + strength * find_occlusion(layer, x, y, offsets, radius));
          }
      });
}

Image compose(const PixelLayer& layer, const std::array<std::uint8_t, 3>& background) {
  Image image{layer.width, layer.height, {}};
  image.pixels.resize(layer.colour.size());
  const Eigen::Vector3f behind = decode_colour(background);
  parallel_for(image.pixels.size(), std::size_t{1} << 15, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Eigen::Vector3f linear = layer.colour[i] + behind * (1.0f - layer.coverage[i]);
      for (int k = 0; k < 3; ++k) {
        const float encoded = 255.0f * std::sqrt(std::clamp(linear[k], 0.0f, 1.0f));
        image.pixels[i][k] = static_cast<std::uint8_t>(encoded + 0.5f);
      }
    }
  });
  return image;
}

}  // namespace phiz
