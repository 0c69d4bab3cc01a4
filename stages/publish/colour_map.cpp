#include "stages/publish/colour_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <span>

#include "stages/publish/bitmap_font.h"

namespace phiz {
namespace {

using Rgb = std::array<std::uint8_t, 3>;

// viridis (van der Walt and Smith, released as CC0), every ninth of its length.
constexpr std::array<Rgb, 10> kSequential = {{{68, 1, 84},
                                              {72, 40, 120},
                                              {62, 74, 137},
                                              {49, 104, 142},
                                              {38, 130, 142},
                                              {31, 158, 137},
                                              {53, 183, 121},
                                              {110, 206, 88},
                                              {181, 222, 43},
                                              {253, 231, 37}}};
// Diverging after Moreland, Diverging Color Maps for Scientific Visualization (2009).
constexpr std::array<Rgb, 5> kDiverging = {
    {{59, 76, 192}, {141, 176, 254}, {221, 221, 221}, {244, 152, 122}, {180, 4, 38}}};
constexpr Rgb kNoData = {165, 165, 165};

std::span<const Rgb> anchors(ColourMap map) {
  if (map == ColourMap::kDiverging) return kDiverging;
  return kSequential;
}

Eigen::Vector3f decode(const Rgb& c) {
  const Eigen::Vector3f v(c[0], c[1], c[2]);
  return (v / 255.0f).cwiseAbs2();
}

Rgb encode(const Eigen::Vector3f& linear) {
  Rgb out{};
  for (int k = 0; k < 3; ++k)
    out[k] = static_cast<std::uint8_t>(std::lround(255.0f * std::sqrt(std::clamp(linear[k], 0.0f, 1.0f))));
  return out;
}

std::string format_number(float value, float range) {
  std::array<char, 32> text{};
  const int digits = range >= 20 ? 0 : range >= 2 ? 1 : range >= 0.2f ? 2 : 3;
  std::snprintf(text.data(), text.size(), "%.*f", digits, static_cast<double>(value));
  return text.data();
}

}  // namespace

Eigen::Vector3f evaluate_colour_map(ColourMap map, float t) {
  if (std::isnan(t)) return decode(kNoData);
  const std::span<const Rgb> colours = anchors(map);
  const float place = std::clamp(t, 0.0f, 1.0f) * static_cast<float>(colours.size() - 1);
  const std::size_t left = std::min(static_cast<std::size_t>(place), colours.size() - 2);
  const float share = place - static_cast<float>(left);
  Eigen::Vector3f mixed;
  for (int k = 0; k < 3; ++k)
    mixed[k] = (static_cast<float>(colours[left][k]) * (1 - share) +
                static_cast<float>(colours[left + 1][k]) * share) /
               255.0f;
  return mixed.cwiseAbs2();
}

void draw_legend(Image& image, const HeatMap& heat) {
  constexpr int kNumbers = 5, kScale = 2;
  const int bar_width = std::max(8, image.width / 40);
  const int bar_height = image.height / 2;
  const float range = heat.high - heat.low;
  std::array<std::string, kNumbers> numbers;
  int text_width = 0;
  for (int k = 0; k < kNumbers; ++k) {
    numbers[k] = format_number(heat.low + range * static_cast<float>(k) / (kNumbers - 1), std::abs(range));
    text_width = std::max(text_width, compute_text_width(numbers[k], kScale));
  }
  const int right = image.width - 10;
  const int left = right - text_width - 6 - bar_width;
  const int top = (image.height - bar_height) / 2;
  for (int y = 0; y < bar_height; ++y) {
    const float t = 1.0f - (static_cast<float>(y) + 0.5f) / static_cast<float>(bar_height);
    const Rgb colour = encode(evaluate_colour_map(heat.map, t));
    for (int x = std::max(left, 0); x < left + bar_width; ++x) image.at(x, top + y) = colour;
  }
  for (int k = 0; k < kNumbers; ++k) {
    const int y = top + bar_height - 1 - (bar_height - 1) * k / (kNumbers - 1);
    for (int x = left + bar_width; x < left + bar_width + 4; ++x) image.at(x, y) = {90, 90, 90};
    draw_text(image, left + bar_width + 6, y - kGlyphHeight * kScale / 2, numbers[k], {});
  }
  const int caption_width = compute_text_width(heat.caption, kScale);
  draw_text(image, std::max(4, right - caption_width), top - kGlyphHeight * kScale - 14, heat.caption, {});
}

}  // namespace phiz
