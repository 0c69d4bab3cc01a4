#include <gtest/gtest.h>
#include <zlib.h>

#include <sstream>

#include "formats/image.h"
#include "tests/formats/hostile_bytes.h"

namespace phiz {
namespace {

Image sample_picture(int width, int height) {
  Image image{width, height, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.pixels.push_back({static_cast<std::uint8_t>(x * 7), static_cast<std::uint8_t>(y * 5),
                              static_cast<std::uint8_t>(test::random().below(256))});
    }
  }
  return image;
}

std::string write(const Image& image) {
  std::ostringstream out;
  write_png(image, out);
  return out.str();
}

Image read(const std::string& bytes) {
  std::istringstream in(bytes);
  return read_png(in);
}

TEST(Png, ReadsWhatItWrote) {
  for (const auto& [width, height] : {std::pair{1, 1}, {61, 3}, {3, 61}, {256, 128}}) {
    const Image image = sample_picture(width, height);
    const Image copy = read(write(image));
    EXPECT_EQ(copy.width, width);
    EXPECT_EQ(copy.height, height);
    EXPECT_EQ(copy.pixels, image.pixels);
  }
}

TEST(Png, SamePictureSameBytes) {
  const Image image = sample_picture(40, 30);
  const std::string bytes = write(image);
  EXPECT_EQ(write(image), bytes);
  EXPECT_EQ(write(read(bytes)), bytes);
  EXPECT_EQ(bytes.find("tIME"), std::string::npos);
}

TEST(Png, RefusesWhatIsNoPicture) {
  EXPECT_THROW(write(Image{}), FormatError);
  EXPECT_THROW(write(Image{2, 2, {}}), FormatError);
  EXPECT_THROW(read(""), FormatError);
  EXPECT_THROW(read("P6 1 1 255 abc"), FormatError);
}

TEST(Png, ALyingSizeIsRefusedBeforeAllocation) {
  std::string bytes = write(sample_picture(4, 4));
  bytes[18] = bytes[22] = '\x3f';  // 16132 x 16132
  const uLong check = crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data() + 12), 17);
  for (int k = 0; k < 4; ++k)
    bytes[29 + static_cast<std::size_t>(k)] = static_cast<char>(check >> (24 - 8 * k));
  try {
    read(bytes);
    FAIL();
  } catch (const FormatError& error) {
    EXPECT_NE(std::string(error.what()).find("claims to be"), std::string::npos) << error.what();
  }
}

TEST(Png, SurvivesTruncationAndNoise) {
  const std::string bytes = write(sample_picture(9, 7));
  // the twelve bytes of the end chunk carry nothing: a reader may do without
  for (std::size_t length = 0; length + 16 < bytes.size(); ++length) {
    EXPECT_THROW(read(bytes.substr(0, length)), FormatError) << length;
  }
  test::expect_mutations_survived(bytes, 5000, read);
}

}  // namespace
}  // namespace phiz
