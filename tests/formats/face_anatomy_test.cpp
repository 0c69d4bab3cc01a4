#include "formats/face_anatomy.h"

#include <gtest/gtest.h>

#include <sstream>

#include "formats/error.h"
#include "tests/formats/hostile_bytes.h"

namespace phiz {
namespace {

const std::string kFace = R"({"schema": "phiz.anatomy.1",
 "condyles": {"right": {"tragus_right": 0.75, "jaw_02": 0.25}, "left": {"tragus_left": 1}},
 "jaw": [{"name": "jawOpen", "turn_deg": 15, "slide_mm": [0, -1, 1]}],
 "ties": [{"kind": "slack", "pair": true, "amount": 0.9, "zone": {"points": [{"chin": 1}], "radius_mm": 20}},
          {"kind": "jaw", "zone": {"region": "lips", "radius_mm": 3, "plateau": 0.5}}],
 "loose": ["inner_mouth"],
 "rims": [{"name": "lips", "upper": ["a", "b"], "lower": ["a", "c", "b"]}],
 "volumes": [{"name": "cheek", "pair": true, "zone": {"points": [{"chin": 1}]}, "stiffness": 2}],
 "muscles": [{"name": "zygomaticMajor", "kind": "linear", "pair": true, "fibres": [[{"a": 0.4, "b": 0.6}, {"c": 1}]],
              "way_mm": 11, "radius_mm": 17, "bulge_mm": 3, "depth_mm": 6},
             {"name": "oris", "kind": "sphincter", "line": {"from": {"a": 1}, "to": {"b": 1}},
              "zone": {"points": [{"c": 1}]}, "across": 0.1, "along": 0.4, "retreat": {"region": "eyes", "slide_mm": [0, 0, -4]}}],
 "expressions": {"smile": {"zygomaticMajorLeft": 0.8, "zygomaticMajorRight": 0.8}},
 "controls": {"jawOpen": {"jawOpen": 1}}})";

FaceAnatomy read(const std::string& text) {
  std::istringstream in(text);
  return read_face_anatomy(in);
}

std::string with(const std::string& from, const std::string& to) {
  std::string text = kFace;
  return text.replace(text.find(from), from.size(), to);
}

TEST(FaceAnatomy, SaysWhatStandsInIt) {
  const FaceAnatomy anatomy = read(kFace);
  EXPECT_EQ(activation_names(anatomy),
            (std::vector<std::string>{"jawOpen", "zygomaticMajorLeft", "zygomaticMajorRight", "oris"}));
  EXPECT_EQ(anatomy.condyle_right.at("jaw_02"), 0.25);
  EXPECT_EQ(anatomy.ties[1].kind, SkinTie::Kind::kJaw);
  EXPECT_EQ(anatomy.ties[1].zone.region, "lips");
  EXPECT_EQ(anatomy.muscles[0].fibres[0].size(), 2u);
  EXPECT_EQ(anatomy.muscles[1].retreat_mm.z(), -4);
  EXPECT_EQ(anatomy.expressions.at("smile").at("zygomaticMajorLeft"), 0.8);
}

TEST(FaceAnatomy, RefusesWhatCannotBe) {
  EXPECT_THROW(read(with("phiz.anatomy.1", "phiz.muscle.1")), FormatError);
  EXPECT_THROW(read(with("\"turn_deg\"", "\"turn\"")), FormatError) << "unknown key";
  EXPECT_THROW(read(with("\"kind\": \"linear\"", "\"kind\": \"round\"")), FormatError);
  EXPECT_THROW(read(with("\"kind\": \"linear\"", "\"kind\": \"sphincter\"")), FormatError) << "needs a line";
  EXPECT_THROW(read(with("\"a\": 0.4", "\"a\": 0.5")), FormatError) << "weights do not sum to 1";
  EXPECT_THROW(read(with("\"oris\"", "\"jawOpen\"")), FormatError) << "a name twice";
  EXPECT_THROW(read(with("{\"zygomaticMajorLeft\": 0.8,", "{\"grin\": 0.8,")), FormatError)
      << "no such muscle";
  EXPECT_THROW(read(with("\"plateau\": 0.5", "\"plateau\": 1")), FormatError);
}

TEST(FaceAnatomy, EveryTruncationIsRefused) {
  test::expect_prefixes_refused(kFace, 7, read);
}

TEST(FaceAnatomy, RandomBytesAreSurvived) {
  test::expect_mutations_survived(kFace, 800, read);
}

}  // namespace
}  // namespace phiz
