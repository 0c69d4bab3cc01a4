#include <gtest/gtest.h>

#include <set>

#include "stages/publish/bitmap_font.h"
#include "stages/publish/colour_map.h"
#include "stages/publish/views.h"

namespace phiz {
namespace {

Image paper(int width, int height) {
  Image image{width, height, {}};
  image.pixels.assign(static_cast<std::size_t>(width) * height, {255, 255, 255});
  return image;
}

TEST(BitmapFont, EveryPrintableCharacterHasAShapeOfItsOwn) {
  std::set<std::vector<std::array<std::uint8_t, 3>>> shapes;
  for (char c = ' '; c <= '~'; ++c) {
    Image image = paper(8, 8);
    draw_text(image, 0, 0, std::string(1, c), {.scale = 1});
    EXPECT_EQ(image.pixels == paper(8, 8).pixels, c == ' ') << c;
    EXPECT_TRUE(shapes.insert(image.pixels).second) << c;
  }
}

TEST(BitmapFont, TextStaysWithinItsWidthAndThePicture) {
  const std::string text = "WMg|@ \x01\xff";
  for (const int scale : {1, 3}) {
    Image image = paper(200, 30);
    draw_text(image, 2, 3, text, {.scale = scale});
    int outside = 0;
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 200; ++x)
        outside += image.at(x, y)[0] != 255 && (x < 2 || y < 3 || x >= 2 + compute_text_width(text, scale) ||
                                                y >= 3 + kGlyphHeight * scale);
    EXPECT_EQ(outside, 0);
    draw_text(image, -30, -4, text, {.scale = scale});
    draw_text(image, 190, 28, text, {.scale = scale});
  }
}

TEST(ColourMap, SequentialColoursDarkenEvenly) {
  float before = 2;
  for (int k = 0; k <= 100; ++k) {
    const Eigen::Vector3f c = evaluate_colour_map(ColourMap::kSequential, static_cast<float>(k) / 100);
    const float luminance = 0.2126f * c.x() + 0.7152f * c.y() + 0.0722f * c.z();
    EXPECT_LT(luminance, before);
    before = luminance;
  }
}

TEST(ColourMap, DivergingColoursAreNeutralInTheMiddle) {
  const Eigen::Vector3f middle = evaluate_colour_map(ColourMap::kDiverging, 0.5f);
  EXPECT_NEAR(middle.x(), middle.z(), 1e-6);
  EXPECT_GT(evaluate_colour_map(ColourMap::kDiverging, 0).z(),
            evaluate_colour_map(ColourMap::kDiverging, 0).x());
  EXPECT_GT(evaluate_colour_map(ColourMap::kDiverging, 1).x(),
            evaluate_colour_map(ColourMap::kDiverging, 1).z());
}

TEST(ContactSheet, HoldsEveryPictureInItsRow) {
  Image red = paper(40, 30), blue = paper(60, 20);
  std::fill(red.pixels.begin(), red.pixels.end(), std::array<std::uint8_t, 3>{200, 0, 0});
  std::fill(blue.pixels.begin(), blue.pixels.end(), std::array<std::uint8_t, 3>{0, 0, 200});
  const Image sheet = contact_sheet({{red, blue}, {blue}}, {{"a", "b"}, {}}, "title");
  const auto count = [&](const std::array<std::uint8_t, 3>& colour) {
    return std::count(sheet.pixels.begin(), sheet.pixels.end(), colour);
  };
  EXPECT_EQ(count({200, 0, 0}), 40 * 30);
  EXPECT_EQ(count({0, 0, 200}), 2 * 60 * 20);
  EXPECT_EQ(static_cast<std::size_t>(sheet.width) * sheet.height, sheet.pixels.size());
}

TEST(ContactSheet, OfNothingIsABlankSheet) {
  EXPECT_GT(contact_sheet({}, {}).width, 0);
  EXPECT_GT(contact_sheet({{}, {}}, {{"label without a picture"}}, "only a title").height, 0);
}

}  // namespace
}  // namespace phiz
