#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <sstream>

#include "formats/image.h"
#include "tests/formats/hostile_bytes.h"

namespace phiz {
namespace {

FloatImage sample_image(int width, int height) {
  FloatImage image{width, height, {}, {}};
  image.attributes = {
      {"units", "mm"}, {"templateDigest", "abc"}, {"aNoteOfMoreThanThirtyOneLetters", "x\ny"}};
  for (const char* name : {"P.X", "P.Y", "P.Z", "N.X", "N.Y", "Cd.R", "conf.V", "mask.V"}) {
    std::vector<float>& values = image.channels[name];
    for (int i = 0; i < width * height; ++i) values.push_back(static_cast<float>(test::random().normal()));
  }
  return image;
}

std::string write(const FloatImage& image) {
  std::ostringstream out;
  write_exr(image, out);
  return out.str();
}

FloatImage read(const std::string& bytes) {
  std::istringstream in(bytes);
  return read_exr(in);
}

TEST(Exr, KeepsFloatsExactlyAndDirectionsAndColoursAsHalf) {
  for (const auto& [width, height] : {std::pair{1, 1}, {37, 50}, {64, 16}}) {
    const FloatImage image = sample_image(width, height);
    const FloatImage copy = read(write(image));
    EXPECT_EQ(copy.width, width);
    EXPECT_EQ(copy.height, height);
    EXPECT_EQ(copy.attributes, image.attributes);
    ASSERT_EQ(copy.channels.size(), image.channels.size());
    for (const auto& [name, values] : image.channels) {
      const std::vector<float>& read_values = copy.channels.at(name);
      if (!name.starts_with("N.") && !name.starts_with("Cd.")) {
        EXPECT_EQ(read_values, values) << name;
        continue;
      }
      ASSERT_EQ(read_values.size(), values.size());
      for (std::size_t i = 0; i < values.size(); ++i) {
        EXPECT_NEAR(read_values[i], values[i], std::abs(values[i]) / 2048.0f + 1e-7f) << name;
      }
    }
  }
}

TEST(Exr, SameImageSameBytes) {
  const FloatImage image = sample_image(33, 20);
  const std::string bytes = write(image);
  EXPECT_TRUE(write(image) == bytes);
  EXPECT_TRUE(write(read(bytes)) == bytes);
}

TEST(Exr, RefusesToWriteWhatIsNoImage) {
  const auto refused = [](auto spoil) {
    FloatImage image = sample_image(4, 4);
    spoil(image);
    EXPECT_THROW(write(image), FormatError);
  };
  refused([](FloatImage& image) { image.channels["P.X"][3] = std::numeric_limits<float>::quiet_NaN(); });
  refused([](FloatImage& image) { image.channels["P.X"][3] = std::numeric_limits<float>::infinity(); });
  refused([](FloatImage& image) { image.channels["N.X"][3] = 1e5f; });  // no half
  refused([](FloatImage& image) { image.channels["P.X"].pop_back(); });
  refused([](FloatImage& image) { image.channels.clear(); });
  refused([](FloatImage& image) { image.channels[""] = image.channels["P.X"]; });
  refused([](FloatImage& image) { image.width = 0; });
  refused([](FloatImage& image) { image.width = 5; });
  refused([](FloatImage& image) { image.attributes["compression"] = "none"; });
  refused([](FloatImage& image) { image.attributes["phizSeal"] = "none"; });
}

TEST(Exr, SurvivesTruncationAndNoise) {
  const std::string bytes = write(sample_image(9, 7));
  test::expect_prefixes_refused(bytes, 13, read);
  test::expect_mutations_survived(bytes, 3000, [&bytes](const std::string& mutated) {
    const FloatImage image = read(mutated);
    EXPECT_FALSE(mutated != bytes && mutated.find("phizSeal") != std::string::npos && image.width == 9 &&
                 mutated.find("string\0\x40", mutated.find("phizSeal"), 8) == mutated.find("phizSeal") + 9)
        << "a damaged file with its seal was read";
  });
}

TEST(Exr, FilesWithoutASealSurviveNoiseToo) {
  std::string bytes = write(sample_image(9, 7));
  bytes[bytes.find("phizSeal")] = 'f';  // now another program's attribute
  EXPECT_EQ(read(bytes).attributes.count("fhizSeal"), 1u);
  test::expect_prefixes_refused(bytes, 13, read);
  test::expect_mutations_survived(bytes, 5000, read);
}

std::string number(std::uint32_t value) {
  return {reinterpret_cast<const char*>(&value), 4};
}

std::string attribute(const std::string& name, const std::string& type, const std::string& value) {
  return name + '\0' + type + '\0' + number(static_cast<std::uint32_t>(value.size())) + value;
}

/// A header with this attribute first, then those every file has.
std::string file_with(const std::string& first, std::uint32_t version = 2) {
  const std::string no_channels(1, '\0');
  return "\x76\x2f\x31\x01" + number(version) + first +
         attribute("dataWindow", "box2i", number(0) + number(0) + number(3) + number(3)) + no_channels +
         std::string(64, 'x');
}

TEST(Exr, WhatAHeaderClaimsIsComparedWithTheFileBeforeRoomIsMade) {
  const auto refused = [](const std::string& bytes, const std::string& why) {
    try {
      read(bytes);
      ADD_FAILURE() << "was read: " << why;
    } catch (const FormatError& error) {
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
  };
  // OpenEXR ends a channel list at its empty name, wherever its length says: what follows is read as
  // attributes.
  const std::string hidden = std::string("x\0string\0", 9) + number(0x7fffffff);
  refused(file_with(attribute("channels", "chlist", '\0' + hidden)), "channels are not as long");
  refused(file_with(attribute("texts", "stringvector", number(0x7fffffff))), "list of texts");
  refused(file_with(attribute("preview", "preview", number(50'000) + number(10'000))), "preview");
  refused(file_with(attribute("lineOrder", "lineOrder", "12")), "of no such length");
  refused(file_with(attribute("a", "int", number(1)) + attribute("a", "int", number(2))), "two attributes");
  refused(file_with(attribute("ids", "idmanifest", number(8) + number(0x7fffffff))), "ID manifest");
  refused(file_with({}, 2 | 0x200), "tiled");
  refused(file_with({}), "has no channels");
}

TEST(Exr, RefusesWhatIsNoExr) {
  EXPECT_THROW(read(""), FormatError);
  EXPECT_THROW(read("P6 1 1 255 abc"), FormatError);
}

}  // namespace
}  // namespace phiz
