#include "formats/deformation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>

#include "formats/error.h"
#include "tests/formats/hostile_bytes.h"

namespace phiz {
namespace {

FieldImage random_image(int channels) {
  FieldImage image;
  image.channels = channels;
  image.x = 2, image.y = 3, image.width = 4, image.height = 5;
  for (int i = 0; i < 20 * channels; ++i)
    image.values.push_back(static_cast<float>(test::random().uniform(0.5, 2)));
  return image;
}

Deformation sample() {
  Deformation d;
  d.template_digest = std::string(64, 'a');
  d.width = 12, d.height = 10;
  d.parameters = {{"smile", 0, 1.1}, {"jaw", -0.25, 1}};
  d.fields.resize(4);
  d.fields[0].name = "neutral";
  d.fields[0].type = FieldType::kConstant;
  d.fields[1].name = "smile";
  d.fields[1].parameter = "smile";
  d.fields[1].inputs = {"neutral"};
  d.fields[1].image = random_image(3);
  d.fields[1].scale = {"eye_left", "eye_right", 61.5};
  d.fields[1].interpolation = FieldInterpolation::kBicubic;
  d.fields[2].name = "jawTurn";
  d.fields[2].type = FieldType::kRotate;
  d.fields[2].parameter = "jaw";
  d.fields[2].gain = 0.21;
  d.fields[2].inputs = {"smile"};
  d.fields[2].axis = {{{"a", 0.25}, {"b", 0.75}}, {{"c", 1}}};
  d.fields[2].image = random_image(1);
  d.fields[3].name = "lips";
  d.fields[3].type = FieldType::kBlend;
  d.fields[3].inputs = {"jawTurn", "neutral"};
  d.fields[3].parameter = "jaw";
  d.fields[3].image = random_image(1);
  d.fields[3].origin = "by hand";
  d.output = "lips";
  d.controls = {{"mouthSmileLeft", {"MouthSmileLeft", "mouthSmile_L"}, {{"smile", 1}, {"jaw", 0.1}}},
                {"tongueOut", {}, {}}};
  return d;
}

struct Bytes {
  std::string json, exr;
};

Bytes write(const Deformation& d) {
  std::ostringstream json, exr;
  write_deformation(d, json, exr);
  return {json.str(), exr.str()};
}

Deformation read(const std::string& json_bytes, const std::string& exr_bytes) {
  std::istringstream json(json_bytes), exr(exr_bytes);
  return read_deformation(json, exr);
}

std::string fault_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const FormatError& error) {
    return error.what();
  }
  return {};
}

TEST(Deformation, ComesBackAsItWasWritten) {
  const Deformation d = sample();
  const Bytes bytes = write(d);
  const Deformation back = read(bytes.json, bytes.exr);
  ASSERT_EQ(back.fields.size(), d.fields.size());
  for (std::size_t i = 0; i < d.fields.size(); ++i) {
    const DeformationField &a = d.fields[i], &b = back.fields[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.type, b.type);
    EXPECT_EQ(a.inputs, b.inputs);
    EXPECT_EQ(a.parameter, b.parameter);
    EXPECT_EQ(a.gain, b.gain);
    EXPECT_EQ(a.interpolation, b.interpolation);
    EXPECT_EQ(a.axis.from, b.axis.from);
    EXPECT_EQ(a.axis.to, b.axis.to);
    EXPECT_EQ(a.scale.reference_mm, b.scale.reference_mm);
    EXPECT_EQ(a.image.values, b.image.values);
    EXPECT_EQ(a.image.x, b.image.x);
    EXPECT_EQ(a.image.height, b.image.height);
    EXPECT_EQ(a.origin, b.origin);
  }
  EXPECT_EQ(back.parameters[1].minimum, -0.25);
  EXPECT_EQ(back.controls[0].terms, d.controls[0].terms);
  EXPECT_EQ(back.controls[0].aliases, d.controls[0].aliases);
  const Bytes again = write(back);
  EXPECT_EQ(bytes.json, again.json);
  EXPECT_EQ(bytes.exr, again.exr);
}

TEST(Deformation, CascadeOrderPutsInputsFirstWhateverTheOrderOfTheFile) {
  Deformation d = sample();
  std::reverse(d.fields.begin(), d.fields.end());
  std::vector<std::string> names;
  for (const int i : compute_cascade_order(d)) names.push_back(d.fields[i].name);
  EXPECT_EQ(names, (std::vector<std::string>{"neutral", "smile", "jawTurn", "lips"}));
  d.output = "smile";
  EXPECT_EQ(compute_cascade_order(d).size(), 2u);
}

TEST(Deformation, NamesWhatIsWrong) {
  const auto fault = [](const std::function<void(Deformation&)>& spoil) {
    Deformation d = sample();
    spoil(d);
    return fault_of([&] { check_deformation(d); });
  };
  EXPECT_NE(fault([](Deformation& d) { d.fields[1].inputs = {"lips"}; }).find("loop"), std::string::npos);
  EXPECT_NE(fault([](Deformation& d) { d.fields[1].inputs = {"smile"}; }).find("'smile'"), std::string::npos);
  EXPECT_NE(fault([](Deformation& d) { d.fields[1].inputs = {"nobody"}; }).find("'nobody'"),
            std::string::npos);
  EXPECT_NE(fault([](Deformation& d) { d.fields[1].parameter = "grin"; }).find("'grin'"), std::string::npos);
  EXPECT_NE(fault([](Deformation& d) { d.fields[2].name = "smile"; }).find("twice"), std::string::npos);
  EXPECT_NE(fault([](Deformation& d) { d.fields[1].image.values[3] = NAN; }).find("'smile'"),
            std::string::npos);
  EXPECT_NE(fault([](Deformation& d) { d.fields[1].image.x = 9; }).find("grid"), std::string::npos);
  EXPECT_NE(fault([](Deformation& d) { d.fields[2].axis.from["a"] = 2; }).find("sum to 1"),
            std::string::npos);
  EXPECT_NE(fault([](Deformation& d) { d.fields[2].gain = INFINITY; }).find("gain"), std::string::npos);
  EXPECT_NE(fault([](Deformation& d) { d.parameters[0].minimum = 0.5; }).find("'smile'"), std::string::npos);
  EXPECT_NE(fault([](Deformation& d) { d.controls[1].terms["x"] = 1; }).find("'x'"), std::string::npos);
  EXPECT_NE(fault([](Deformation& d) { d.output = "end"; }).find("'end'"), std::string::npos);
}

TEST(Deformation, RefusesAnUnknownTypeByName) {
  Bytes bytes = write(sample());
  bytes.json.replace(bytes.json.find("\"rotate\""), 8, "\"twist\"");
  EXPECT_NE(fault_of([&] { read(bytes.json, bytes.exr); }).find("'twist'"), std::string::npos);
}

TEST(Deformation, RefusesImagesOfAnotherTemplateOrSize) {
  const Bytes bytes = write(sample());
  Deformation other = sample();
  other.template_digest = std::string(64, 'b');
  EXPECT_NE(fault_of([&] { read(write(other).json, bytes.exr); }).find("another generic head"),
            std::string::npos);
  other = sample();
  other.width = 14;
  EXPECT_NE(fault_of([&] { read(write(other).json, bytes.exr); }).find("nodes"), std::string::npos);
  other = sample();
  other.fields[1].name = "grin";
  other.fields[2].inputs = {"grin"};
  EXPECT_NE(fault_of([&] { read(write(other).json, bytes.exr); }).find("layers"), std::string::npos);
}

TEST(Deformation, EveryPrefixIsRefused) {
  const Bytes bytes = write(sample());
  const std::string whole = bytes.json.substr(0, bytes.json.size() - 1);  // the last is a line's end
  test::expect_prefixes_refused(whole, 1, [&](const std::string& json) { read(json, bytes.exr); });
  test::expect_prefixes_refused(bytes.exr, 7, [&](const std::string& exr) { read(bytes.json, exr); });
}

TEST(Deformation, MutationsAreReadOrRefused) {
  const Bytes bytes = write(sample());
  test::expect_mutations_survived(bytes.json, 1500, [&](const std::string& json) { read(json, bytes.exr); });
  test::expect_mutations_survived(bytes.exr, 500, [&](const std::string& exr) { read(bytes.json, exr); });
}

TEST(Deformation, FindsControlsByAliasAndTheNearestName) {
  const Deformation d = sample();
  EXPECT_EQ(find_control(d, "mouthSmile_L"), 0);
  EXPECT_EQ(find_control(d, "tongueOut"), 1);
  EXPECT_EQ(find_control(d, "mouthSmile"), -1);
  EXPECT_EQ(find_nearest_control(d, "mouthSmleLeft"), "mouthSmileLeft");
  EXPECT_EQ(find_nearest_control(d, "qqqqqqqqqqqqqqqqq"), "");
}

}  // namespace
}  // namespace phiz
