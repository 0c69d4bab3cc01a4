#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <map>
#include <string>
#include <vector>

namespace phiz {

/// 8-bit sRGB picture, row 0 on top.
struct Image {
  int width = 0, height = 0;
  std::vector<std::array<std::uint8_t, 3>> pixels;  ///< width * height
  std::array<std::uint8_t, 3>& at(int x, int y) { return pixels[static_cast<std::size_t>(y) * width + x]; }
  const std::array<std::uint8_t, 3>& at(int x, int y) const { return pixels[static_cast<std::size_t>(y) * width + x]; }
};

void write_png(const Image& image, std::ostream& out);  ///< no time chunk: same picture, same bytes
Image read_png(std::istream& in);                       ///< throws FormatError

/// Named float channels of one size ("P.X", "conf.V"), row 0 on top.
struct FloatImage {
  int width = 0, height = 0;
  std::map<std::string, std::vector<float>> channels;
  std::map<std::string, std::string> attributes;  ///< header strings: units, axes, template digest, schema version
};

void write_exr(const FloatImage& image, std::ostream& out);  ///< ZIP, FLOAT; `N.*` and `Cd.*` HALF
FloatImage read_exr(std::istream& in);                       ///< data window capped at 16384^2 before allocation

}  // namespace phiz
