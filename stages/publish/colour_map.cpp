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

// Pale to dark through orange and red: lightness falls evenly from 0.955 to 0.27 in Oklab (Ottosson 2020).
// Pale at the low end, so that the shape stays readable where there is little to show.
constexpr std::array<Rgb, 9> kSequential = {{{243, 241, 226},
                                             {229, 211, 163},
                                             {220, 178, 100},
                                             {215, 138, 32},
                                             {206, 96, 0},
                                             {187, 52, 20},
                                             {150, 26, 55},
                                             {106, 18, 64},
                                             {63, 16, 55}}};
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

Image append_legend(const Image& picture, const HeatMap& heat, const Rgb& background) {
  constexpr int kNumbers = 5, kGap = 10, kTick = 5;
  const int scale = picture.height >= 300 ? 2 : 1;
  const int bar_width = std::max(8, picture.height / 40), bar_height = std::max(picture.height / 2, kNumbers);
  const int glyph_height = kGlyphHeight * scale;
  std::array<std::string, kNumbers> numbers;
  int content_width = compute_text_width(heat.caption, scale);
  for (int k = 0; k < kNumbers; ++k) {
    const float range = heat.high - heat.low;
    numbers[k] = format_number(heat.low + range * static_cast<float>(k) / (kNumbers - 1), std::abs(range));
    content_width = std::max(content_width, bar_width + 2 * kTick + compute_text_width(numbers[k], scale));
  }
  Image image;
  image.width = picture.width + content_width + 2 * kGap;
  image.height = picture.height;
  image.pixels.assign(static_cast<std::size_t>(image.width) * image.height, background);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) image.at(x, y) = picture.at(x, y);

  const int left = picture.width + kGap, top = (image.height - bar_height) / 2;
  for (int y = 0; y < bar_height; ++y) {
    const float t = 1.0f - (static_cast<float>(y) + 0.5f) / static_cast<float>(bar_height);
    const Rgb colour = encode(evaluate_colour_map(heat.map, t));
    for (int x = left; x < left + bar_width; ++x) image.at(x, top + y) = colour;
  }
  const TextStyle style = {.scale = scale};
  for (int k = 0; k < kNumbers; ++k) {
    const int y = top + bar_height - 1 - (bar_height - 1) * k / (kNumbers - 1);
    for (int x = left + bar_width; x < left + bar_width + kTick; ++x) image.at(x, y) = style.colour;
    draw_text(image, left + bar_width + 2 * kTick, y - glyph_height / 2, numbers[k], style);
  }
  draw_text(image, left, top - 2 * glyph_height - 4, heat.caption, style);
  return image;
}

}  // namespace phiz
