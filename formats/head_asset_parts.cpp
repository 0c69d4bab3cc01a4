#include "formats/head_asset_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "formats/error.h"
#include "formats/residual_coder.h"

namespace phiz::head_asset_parts {
namespace {

/// For each vertex three earlier ones a, b, c with a + b - c a guess at its value: the triangle c a b lies
/// beyond the edge a b of one of its own. Where there is none a = b = c is an earlier neighbour, or the
/// vertex before.
std::vector<std::array<int, 3>> find_parallelograms(const LevelTopology& control,
                                                    const std::vector<Eigen::Vector3i>& triangles) {
  std::vector<std::array<int, 3>> guesses(control.vertex_count());
  for (std::size_t v = 0; v < guesses.size(); ++v) {
    const std::span<const int> earlier = control.earlier(v);
    const int beside = earlier.empty() ? static_cast<int>(v) - 1 : earlier.back();
    guesses[v] = {beside, beside, beside};
  }
  struct Side {
    int low, high, apex;
    bool operator<(const Side& other) const { return low != other.low ? low < other.low : high < other.high; }
  };
  std::vector<Side> sides;
  for (const Eigen::Vector3i& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), t[(k + 2) % 3]});
    }
  }
  std::stable_sort(sides.begin(), sides.end());
  for (std::size_t i = 1; i < sides.size(); ++i) {
    if (sides[i - 1] < sides[i]) continue;
    const int first = sides[i - 1].apex, second = sides[i].apex;
    const int v = std::max(first, second), c = std::min(first, second);
    if (v > sides[i].high && v > c) guesses[v] = {sides[i].low, sides[i].high, c};
  }
  return guesses;
}

}  // namespace

void check_steps(double displacement_step_mm, double position_step_mm) {
  const auto within = [](double step, double least) { return step >= least && step <= 10.0; };
  if (!within(displacement_step_mm, 1e-5) || !within(position_step_mm, 1e-4)) {
    throw FormatError("quantisation step is out of range");
  }
}

std::uint32_t sum_of(std::string_view bytes) {
  static const std::array<std::uint32_t, 256> table = [] {
    std::array<std::uint32_t, 256> made{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t x = i;
      for (int k = 0; k < 8; ++k) x = x >> 1 ^ (x & 1 ? 0xedb88320u : 0u);
      made[i] = x;
    }
    return made;
  }();
  std::uint32_t sum = 0xffffffffu;
  for (const char c : bytes) sum = sum >> 8 ^ table[(sum ^ static_cast<unsigned char>(c)) & 255];
  return ~sum;
}

std::int32_t to_steps(double value, double step, const char* what, std::size_t idx) {
  const double steps = value / step;
  if (!(std::abs(steps) < kLargestSteps)) {
    throw FormatError(std::string(what) + " is not finite or too large (" + std::to_string(idx) + ")");
  }
  return static_cast<std::int32_t>(std::floor(steps + 0.5));
}

std::string encode_texture(const LevelTopology& control, const std::vector<Eigen::Vector3i>& triangles,
                           const std::vector<Eigen::Vector2i>& texture) {
  const auto guesses = find_parallelograms(control, triangles);
  ResidualModel model;
  std::string parts[2];
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<std::int32_t> numbers;
    for (std::size_t v = 0; v < texture.size(); ++v) {
      const auto& [a, b, c] = guesses[v];
      const int guess = a < 0 ? 0 : texture[a][axis] + texture[b][axis] - texture[c][axis];
      numbers.push_back(texture[v][axis] - guess);
    }
    parts[axis] = model.encode(control, numbers);
  }
  const auto length = static_cast<std::uint32_t>(parts[0].size());
  std::string bytes(4, '\0');
  for (int k = 0; k < 4; ++k) bytes[k] = static_cast<char>(length >> (8 * k) & 255);
  return bytes + parts[0] + parts[1];
}

std::vector<Eigen::Vector2i> decode_texture(const LevelTopology& control,
                                            const std::vector<Eigen::Vector3i>& triangles,
                                            std::string_view bytes, int steps) {
  std::size_t length = 0;
  for (std::size_t k = 0; k < 4 && k < bytes.size(); ++k)
    length |= std::size_t{static_cast<unsigned char>(bytes[k])} << (8 * k);
  if (bytes.size() < 4 || length > bytes.size() - 4) throw FormatError("texture coordinates end early");
  const auto guesses = find_parallelograms(control, triangles);
  const std::string_view parts[2] = {bytes.substr(4, length), bytes.substr(4 + length)};
  ResidualModel model;
  std::vector<Eigen::Vector2i> texture(control.vertex_count());
  for (int axis = 0; axis < 2; ++axis) {
    const std::vector<std::int32_t> numbers = model.decode(control, parts[axis]);
    for (std::size_t v = 0; v < texture.size(); ++v) {
      const auto& [a, b, c] = guesses[v];
      const int guess = a < 0 ? 0 : texture[a][axis] + texture[b][axis] - texture[c][axis];
      texture[v][axis] = guess + numbers[v];
      if (texture[v][axis] < 0 || texture[v][axis] > steps)
        throw FormatError("texture coordinates are out of range");
    }
  }
  return texture;
}

}  // namespace phiz::head_asset_parts
