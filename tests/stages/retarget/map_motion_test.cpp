#include <gtest/gtest.h>

#include "stages/geometry/error.h"
#include "stages/retarget/retarget.h"
#include "tests/stages/deform/deform_samples.h"

namespace phiz {
namespace {

Motion motion_of(std::vector<std::string> names, std::vector<float> values) {
  Motion motion;
  motion.names = std::move(names);
  motion.values = std::move(values);
  for (std::size_t i = 0; i < motion.values.size() / motion.names.size(); ++i)
    motion.times_s.push_back(static_cast<double>(i) / 60);
  return motion;
}

std::string fault_of(const Motion& motion) {
  try {
    map_motion(test::make_sample_deformation(), motion);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return {};
}

TEST(MapMotion, CurvesBecomeParameters) {
  const Deformation rig = test::make_sample_deformation();  // mouthSmile: smile + raise / 4; jawOpen: open
  const ParameterTrack track =
      map_motion(rig, motion_of({"MouthSmile", "HeadYaw", "jawOpen"}, {0.5f, 9, 0.25f, 1.5f, 9, -1}));
  ASSERT_EQ(track.frame_count(), 2u);
  EXPECT_EQ(track.unused, std::vector<std::string>{"HeadYaw"});
  EXPECT_EQ(track.frame(0)[0], 0.5f);
  EXPECT_EQ(track.frame(0)[1], 0.125f);
  EXPECT_EQ(track.frame(0)[2], 0.25f);
  EXPECT_EQ(track.frame(1)[0], 1.1f);  // cut at the parameter's range
  EXPECT_EQ(track.frame(1)[2], 0);
  EXPECT_EQ(track.clamped_values, 2u);
}

TEST(MapMotion, NamesOfTheFiftyTwoThatTheRigLacksAreToldOf) {
  const ParameterTrack track =
      map_motion(test::make_sample_deformation(), motion_of({"jawOpen", "EyeBlinkLeft"}, {1, 1}));
  EXPECT_EQ(track.unused, std::vector<std::string>{"EyeBlinkLeft"});
}

TEST(MapMotion, UnknownNamesAreRefusedWithTheNearest) {
  const std::string fault = fault_of(motion_of({"jawOpen", "mouthSmilee"}, {1, 1}));
  EXPECT_NE(fault.find("'mouthSmilee'"), std::string::npos);
  EXPECT_NE(fault.find("'mouthSmile'"), std::string::npos);
  EXPECT_NE(fault_of(motion_of({"EyeBlinkLeft"}, {1})).find("no column"), std::string::npos);
  EXPECT_NE(fault_of(motion_of({"mouthSmile", "MouthSmile"}, {1, 1})).find("same control"),
            std::string::npos);
}

}  // namespace
}  // namespace phiz
