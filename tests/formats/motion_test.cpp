#include "formats/motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>

#include "formats/error.h"
#include "tests/formats/hostile_bytes.h"

namespace phiz {
namespace {

Motion sample(int frames = 12, double rate = 30) {
  Motion motion;
  motion.names = {"jawOpen", "mouthSmileLeft", "HeadYaw"};
  motion.frames_per_second = rate;
  for (int i = 0; i < frames; ++i) {
    motion.times_s.push_back(i / rate);
    for (int k = 0; k < 3; ++k)
      motion.values.push_back(static_cast<float>(test::random().uniform(-0.2, 1.053)));
  }
  return motion;
}

Motion read(const std::string& text) {
  std::istringstream in(text);
  return read_motion(in);
}

std::string text_of(void (*write)(const Motion&, std::ostream&), const Motion& motion) {
  std::ostringstream out;
  write(motion, out);
  return out.str();
}

std::string fault_of(const std::string& text) {
  try {
    read(text);
  } catch (const FormatError& error) {
    return error.what();
  }
  return {};
}

std::string live_link(const std::vector<std::string>& timecodes) {
  std::string text = "Timecode,BlendShapeCount,JawOpen,HeadYaw";
  for (const std::string& code : timecodes) text.append("\n").append(code).append(",61,0.25,-0.1");
  return text + "\n";
}

TEST(Motion, PlainFilesComeBackExactly) {
  const Motion motion = sample();
  for (const auto write : {write_motion_csv, write_motion_json}) {
    const std::string text = text_of(write, motion);
    const Motion back = read(text);
    EXPECT_EQ(back.names, motion.names);
    EXPECT_EQ(back.times_s, motion.times_s);
    EXPECT_EQ(back.values, motion.values);
    EXPECT_EQ(back.frames_per_second, motion.frames_per_second);
    EXPECT_EQ(text_of(write, back), text);
  }
}

TEST(Motion, LiveLinkHasItsColumnsAndKeepsValues) {
  const Motion motion = sample(90, 60);
  const std::string text = text_of(write_live_link_csv, motion);
  EXPECT_TRUE(text.starts_with("Timecode,BlendShapeCount,EyeBlinkLeft,EyeLookDownLeft,"));
  EXPECT_EQ(std::count(text.begin(), text.begin() + static_cast<long>(text.find('\n')), ','), 62);
  const Motion back = read(text);
  EXPECT_EQ(back.names.size(), 61u);
  EXPECT_EQ(back.frames_per_second, 60);
  EXPECT_TRUE(back.gaps.empty());
  const auto column = [&](const char* name) {
    return static_cast<std::size_t>(std::find(back.names.begin(), back.names.end(), name) -
                                    back.names.begin());
  };
  for (std::size_t i = 0; i < 90; ++i) {
    EXPECT_NEAR(back.times_s[i], motion.times_s[i], 1e-4);
    EXPECT_EQ(back.frame(i)[column("JawOpen")], motion.frame(i)[0]);
    EXPECT_EQ(back.frame(i)[column("MouthSmileLeft")], motion.frame(i)[1]);
    EXPECT_EQ(back.frame(i)[column("HeadYaw")], motion.frame(i)[2]);
    EXPECT_EQ(back.frame(i)[column("TongueOut")], 0);
  }
}

TEST(Motion, OrderOfColumnsDoesNotMatter) {
  const Motion a = read("time_s,jawOpen,browInnerUp\n0,0.5,0.25\n0.1,1,0.75\n");
  const Motion b = read("browInnerUp,time_s,jawOpen\n0.25,0,0.5\n0.75,0.1,1\n");
  EXPECT_EQ(a.times_s, b.times_s);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(a.frame(i)[0], b.frame(i)[1]);
    EXPECT_EQ(a.frame(i)[1], b.frame(i)[0]);
  }
}

TEST(Motion, RateComesFromTheTimecode) {
  std::vector<std::string> sixty, thirty, twenty_four;
  for (int i = 50; i < 140; ++i) {
    const auto code = [](int seconds, double frame) {
      char text[32];
      std::snprintf(text, sizeof(text), "10:59:%02d:%06.3f", seconds, frame);
      return std::string(text);
    };
    sixty.push_back(code(i / 60, i % 60 + 0.297));
    thirty.push_back(code(i / 30, i % 30 + 0.5));
    twenty_four.push_back(code(i / 24, i % 24));
  }
  EXPECT_EQ(read(live_link(sixty)).frames_per_second, 60);
  EXPECT_EQ(read(live_link(thirty)).frames_per_second, 30);
  EXPECT_EQ(read(live_link(twenty_four)).frames_per_second, 24);
  // counted at 60, every second one written
  std::vector<std::string> halves;
  for (std::size_t i = 0; i < sixty.size(); i += 2) halves.push_back(sixty[i]);
  EXPECT_EQ(read(live_link(halves)).frames_per_second, 30);
}

TEST(Motion, GapsAreNamedAndResamplingFillsThem) {
  const Motion motion = read("time_s,a\n0,0\n0.1,1\n0.2,2\n0.5,5\n0.6,6\n");
  EXPECT_EQ(motion.frames_per_second, 10);
  ASSERT_EQ(motion.gaps.size(), 1u);
  EXPECT_EQ(motion.gaps[0].after_frame, 2u);
  EXPECT_EQ(motion.gaps[0].missing_frames, 2);
  const Motion even = resample_motion(motion, 20);
  ASSERT_EQ(even.frame_count(), 13u);
  for (std::size_t i = 0; i < 13; ++i) {
    EXPECT_NEAR(even.times_s[i], 0.05 * static_cast<double>(i), 1e-12);
    EXPECT_NEAR(even.frame(i)[0], 0.5 * static_cast<double>(i), 1e-5);
  }
  ASSERT_EQ(even.gaps.size(), 1u);
  EXPECT_EQ(even.gaps[0].missing_frames, 5);
}

TEST(Motion, MidnightIsNoWayBack) {
  const Motion motion =
      read(live_link({"23:59:59:58.000", "23:59:59:59.000", "00:00:00:00.000", "00:00:00:01.000"}));
  EXPECT_EQ(motion.frames_per_second, 60);
  EXPECT_TRUE(motion.gaps.empty());
}

TEST(Motion, SaysWhereAFileIsWrong) {
  EXPECT_NE(fault_of("time_s,a,a\n0,1,1\n").find("'a' twice"), std::string::npos);
  EXPECT_NE(fault_of("time_s,a,b\n0,1,1\n0.1,1\n").find("line 3"), std::string::npos);
  EXPECT_NE(fault_of("time_s,jawOpen\n0,1\n0.1,nan\n").find("line 3, column jawOpen"), std::string::npos);
  EXPECT_NE(fault_of("time_s,jawOpen\n0,x\n").find("'x'"), std::string::npos);
  EXPECT_NE(fault_of("time_s,a\n0.1,1\n0.1,2\n").find("line 3"), std::string::npos);
  EXPECT_NE(fault_of("a,b\n1,2\n").find("Timecode"), std::string::npos);
  EXPECT_NE(fault_of("frame,a\n0,1\n").find("rate"), std::string::npos);
  EXPECT_NE(fault_of(live_link({"10:00:00"})).find("timecode"), std::string::npos);
  EXPECT_NE(fault_of(live_link({"10:00:01:00.0", "10:00:00:00.0"})).find("line 3"), std::string::npos);
  EXPECT_NE(fault_of("time_s,a\n"), "");
  EXPECT_NE(fault_of(""), "");
  EXPECT_EQ(fault_of("# fps 25\nframe,a\n0,1\n1,2\n"), "");
}

TEST(Motion, AnyPrefixIsAMotionOrRefused) {
  const Motion motion = sample();
  for (const auto write : {write_motion_csv, write_motion_json, write_live_link_csv}) {
    const std::string text = text_of(write, motion);
    for (std::size_t length = 0; length < text.size(); length += 1 + length / 200) {
      try {
        check_motion(read(text.substr(0, length)));
      } catch (const FormatError&) {
      }
    }
    test::expect_mutations_survived(text, 400, [](const std::string& bytes) { check_motion(read(bytes)); });
  }
  const std::string json = text_of(write_motion_json, motion);
  test::expect_prefixes_refused(json.substr(0, json.size() - 1), 1,
                                [](const std::string& text) { read(text); });
}

TEST(Motion, KnowsTheNamesOfArkit) {
  EXPECT_EQ(arkit_names().size(), 52u);
  EXPECT_EQ(find_arkit_name("JawOpen"), "jawOpen");
  EXPECT_EQ(find_arkit_name("mouthSmile_L"), "mouthSmileLeft");
  EXPECT_EQ(find_arkit_name("mouthLeft"), "mouthLeft");
  EXPECT_EQ(find_arkit_name("HeadYaw"), "");
}

}  // namespace
}  // namespace phiz
