#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "formats/image.h"

namespace phiz {

inline constexpr int kGlyphWidth = 5, kGlyphHeight = 7, kGlyphAdvance = 6;

/// Width in pixels of one line of text.
int compute_text_width(std::string_view text, int scale);

struct TextStyle {
  int scale = 2;  ///< pixels a dot
  std::array<std::uint8_t, 3> colour = {40, 40, 44};
};

/// Draws printable ASCII with its upper left corner at (x, y), clipped at the picture's edges; other bytes
/// become '?'.
void draw_text(Image& image, int x, int y, std::string_view text, const TextStyle& style);

}  // namespace phiz
