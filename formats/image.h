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
  const std::array<std::uint8_t, 3>& at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * width + x];
  }
};

/// PNG, 8-bit RGB, sides up to 16384. No time chunk, fixed filter and level: same picture, same bytes.
/// read_png takes any PNG; what is transparent comes out on white. Both throw FormatError.
void write_png(const Image& image, std::ostream& out);
Image read_png(std::istream& in);

/// Named float channels of one size ("P.X", "conf.V"), row 0 on top.
struct FloatImage {
  int width = 0, height = 0;
  std::map<std::string, std::vector<float>> channels;  ///< width * height finite numbers each; at least one
  std::map<std::string, std::string>
      attributes;  ///< header strings: units, axes, template digest, schema version
};

/// OpenEXR scan lines, ZIP, sides up to 16384. Channels are FLOAT, but `N.*` and `Cd.*` are HALF. Same image,
/// same bytes; a digest of the content stands in the attribute `phizSeal` and a damaged file is refused.
/// read_exr takes any flat EXR without subsampling, half and integer channels become float, and only string
/// attributes are kept. Both throw FormatError.
void write_exr(const FloatImage& image, std::ostream& out);
FloatImage read_exr(std::istream& in);

}  // namespace phiz
