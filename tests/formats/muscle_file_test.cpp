#include "formats/muscle_file.h"

#include <gtest/gtest.h>

#include <sstream>

#include "formats/error.h"
#include "tests/formats/hostile_bytes.h"

namespace phiz {
namespace {

const std::string kMuscle = R"({"schema": "phiz.muscle.1", "name": "risorius", "pair": true, "stage": 0,
 "pulls": [{"centre": {"mouth_left_corner": 1}, "radii_mm": [25, 17, 30], "toward": {"jaw_13": 0.6, "tragus_left": 0.4},
            "amplitude_mm": 7, "plateau": 0.1}],
 "masks": [{"kind": "plane", "point": {"nose_bridge_0": 1}, "normal": [1, 0, 0], "blend_mm": 6},
           {"kind": "region", "region": "eyes", "rings": 1, "invert": true}],
 "scale": {"from": "a", "to": "b"}})";
const std::string kRig =
    R"({"schema": "phiz.rig.1", "muscles": ["risorius"], "controls": {"mouthStretchLeft": {"risoriusLeft": 1}}})";

MuscleFile read(const std::string& text) {
  std::istringstream in(text);
  return read_muscle_file(in);
}

std::string with(const std::string& from, const std::string& to) {
  std::string text = kMuscle;
  return text.replace(text.find(from), from.size(), to);
}

TEST(MuscleFile, SaysWhatStandsInIt) {
  const MuscleFile muscle = read(kMuscle);
  EXPECT_EQ(muscle.name, "risorius");
  EXPECT_TRUE(muscle.is_pair);
  ASSERT_EQ(muscle.pulls.size(), 1u);
  EXPECT_EQ(muscle.pulls[0].toward->at("jaw_13"), 0.6);
  EXPECT_EQ(muscle.pulls[0].amplitude_mm, 7);
  ASSERT_EQ(muscle.masks.size(), 2u);
  EXPECT_TRUE(muscle.masks[1].is_inverted);
  EXPECT_EQ(muscle.scale_to, "b");
  std::istringstream in(kRig);
  const RigFile rig = read_rig_file(in);
  EXPECT_EQ(rig.muscles, std::vector<std::string>{"risorius"});
  EXPECT_EQ(rig.controls.at(0).terms.at("risoriusLeft"), 1);
}

TEST(MuscleFile, RefusesUnknownKeysKindsAndValues) {
  EXPECT_THROW(read(with("\"stage\": 0", "\"stage\": 7")), FormatError);
  EXPECT_THROW(read(with("\"stage\"", "\"stag\"")), FormatError);
  EXPECT_THROW(read(with("\"plane\"", "\"plain\"")), FormatError);
  EXPECT_THROW(read(with("[25, 17, 30]", "[25, 0, 30]")), FormatError);
  EXPECT_THROW(read(with("[25, 17, 30]", "[25, 17]")), FormatError);
  EXPECT_THROW(read(with("\"plateau\": 0.1", "\"plateau\": 1")), FormatError);
  EXPECT_THROW(read(with("phiz.muscle.1", "phiz.muscle.9")), FormatError);
  EXPECT_THROW(read(with("\"pair\": true", "\"type\": \"rotate\"")), FormatError);  // without axis
}

TEST(MuscleFile, PrefixesAndMutationsAreReadOrRefused) {
  test::expect_prefixes_refused(kMuscle, 1, [](const std::string& text) { read(text); });
  test::expect_mutations_survived(kMuscle, 2000, [](const std::string& text) { read(text); });
  test::expect_mutations_survived(kRig, 1000, [](const std::string& text) {
    std::istringstream in(text);
    read_rig_file(in);
  });
}

}  // namespace
}  // namespace phiz
