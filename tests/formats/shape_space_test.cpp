#include "formats/shape_space.h"

#include <gtest/gtest.h>

#include <sstream>

#include "formats/error.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

ShapeSpace sample_space() {
  ShapeSpace space;
  space.template_digest = "abc";
  space.width = 5;
  space.height = 4;
  const auto numbers = [](std::size_t count) {
    std::vector<float> values;
    for (std::size_t i = 0; i < count; ++i) values.push_back(static_cast<float>(test::random().normal()));
    return values;
  };
  space.weights.assign(20, 0.5f);
  space.mean = numbers(60);
  space.components = {numbers(60), numbers(60)};
  space.variances = {3.25, 0.125};
  space.total_variance = 4;
  space.subjects = {{"a", {1.5, -2}}, {"b", {0.1, 0.2}}};
  return space;
}

struct Files {
  std::string json, exr;
};

Files files_of(const ShapeSpace& space) {
  std::ostringstream json, exr;
  write_shape_space(space, json, exr);
  return {json.str(), exr.str()};
}

ShapeSpace read(const Files& files) {
  std::istringstream json(files.json), exr(files.exr);
  return read_shape_space(json, exr);
}

TEST(ShapeSpace, ComesBackAsItWasAndToTheSameBytes) {
  const ShapeSpace space = sample_space();
  const Files files = files_of(space);
  const ShapeSpace back = read(files);
  EXPECT_EQ(back.mean, space.mean);
  EXPECT_EQ(back.weights, space.weights);
  EXPECT_EQ(back.components, space.components);
  EXPECT_EQ(back.variances, space.variances);
  EXPECT_EQ(back.subjects, space.subjects);
  EXPECT_EQ(back.template_digest, "abc");
  const Files again = files_of(back);
  EXPECT_EQ(again.json, files.json);
  EXPECT_EQ(again.exr, files.exr);
}

TEST(ShapeSpace, RefusesWhatDoesNotBelongTogether) {
  ShapeSpace space = sample_space();
  space.components.pop_back();
  EXPECT_THROW(files_of(space), FormatError);
  space = sample_space();
  space.weights[3] = 0;
  EXPECT_THROW(files_of(space), FormatError);
  space = sample_space();
  space.subjects["c"] = {1};
  EXPECT_THROW(files_of(space), FormatError);
  ShapeSpace other = sample_space();
  other.template_digest = "def";
  EXPECT_THROW(read({files_of(sample_space()).json, files_of(other).exr}), FormatError);
  other = sample_space();
  other.components.pop_back();
  other.variances.pop_back();
  other.subjects.clear();
  EXPECT_THROW(read({files_of(sample_space()).json, files_of(other).exr}), FormatError);
}

TEST(ShapeSpace, EveryTruncationIsRefused) {
  const Files files = files_of(sample_space());
  for (std::size_t length = 0; length + 2 < files.json.size(); length += 5)
    EXPECT_THROW(read({files.json.substr(0, length), files.exr}), FormatError) << length;
  for (std::size_t length = 0; length < files.exr.size(); length += 7)
    EXPECT_THROW(read({files.json, files.exr.substr(0, length)}), FormatError) << length;
}

}  // namespace
}  // namespace phiz
