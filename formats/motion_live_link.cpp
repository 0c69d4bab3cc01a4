#include <cmath>

#include "formats/error.h"
#include "formats/motion.h"
#include "formats/motion_parts.h"
#include "formats/text.h"

namespace phiz {
namespace {

/// The blend shapes in the order of the app's own files.
constexpr const char* kColumns[] = {"EyeBlinkLeft",
                                    "EyeLookDownLeft",
                                    "EyeLookInLeft",
                                    "EyeLookOutLeft",
                                    "EyeLookUpLeft",
                                    "EyeSquintLeft",
                                    "EyeWideLeft",
                                    "EyeBlinkRight",
                                    "EyeLookDownRight",
                                    "EyeLookInRight",
                                    "EyeLookOutRight",
                                    "EyeLookUpRight",
                                    "EyeSquintRight",
                                    "EyeWideRight",
                                    "JawForward",
                                    "JawRight",
                                    "JawLeft",
                                    "JawOpen",
                                    "MouthClose",
                                    "MouthFunnel",
                                    "MouthPucker",
                                    "MouthRight",
                                    "MouthLeft",
                                    "MouthSmileLeft",
                                    "MouthSmileRight",
                                    "MouthFrownLeft",
                                    "MouthFrownRight",
                                    "MouthDimpleLeft",
                                    "MouthDimpleRight",
                                    "MouthStretchLeft",
                                    "MouthStretchRight",
                                    "MouthRollLower",
                                    "MouthRollUpper",
                                    "MouthShrugLower",
                                    "MouthShrugUpper",
                                    "MouthPressLeft",
                                    "MouthPressRight",
                                    "MouthLowerDownLeft",
                                    "MouthLowerDownRight",
                                    "MouthUpperUpLeft",
                                    "MouthUpperUpRight",
                                    "BrowDownLeft",
                                    "BrowDownRight",
                                    "BrowInnerUp",
                                    "BrowOuterUpLeft",
                                    "BrowOuterUpRight",
                                    "CheekPuff",
                                    "CheekSquintLeft",
                                    "CheekSquintRight",
                                    "NoseSneerLeft",
                                    "NoseSneerRight",
                                    "TongueOut"};

std::string two_digits(int value) {
  return std::string(value < 10 ? "0" : "").append(std::to_string(value));
}

/// Counts whole frames at the motion's own rate, rounded up to a whole number of frames a second.
std::string timecode_of(double time_s, double rate) {
  const double count = std::ceil(rate - 1e-9);
  const auto thousandths = static_cast<long long>(std::llround(time_s * count * 1000));
  const auto per_second = static_cast<long long>(count) * 1000;
  const long long seconds = thousandths / per_second, frame = thousandths % per_second;
  std::string text = two_digits(static_cast<int>(seconds / 3600)) + ":" +
                     two_digits(static_cast<int>(seconds / 60 % 60)) + ":" +
                     two_digits(static_cast<int>(seconds % 60)) + ":" +
                     two_digits(static_cast<int>(frame / 1000)) + ".";
  std::string sub = std::to_string(frame % 1000);
  return text + std::string(3 - sub.size(), '0') + sub;
}

}  // namespace

void write_live_link_csv(const Motion& motion, std::ostream& out) {
  check_motion(motion);
  if (motion.times_s.back() - motion.times_s.front() >= 24 * 3600.0)
    throw FormatError("a motion of a day or more has no timecode");
  std::vector<std::string> columns(std::begin(kColumns), std::end(kColumns));
  for (const std::string_view angle : live_link_angles()) columns.emplace_back(angle);
  std::string text = "Timecode,BlendShapeCount";
  std::vector<int> sources;
  for (const std::string& column : columns) {
    text.append(",").append(column);
    sources.push_back(-1);
    const std::string wanted = find_arkit_name(column);
    for (std::size_t k = 0; k < motion.names.size(); ++k) {
      if (motion.names[k] == column || (!wanted.empty() && find_arkit_name(motion.names[k]) == wanted))
        sources.back() = static_cast<int>(k);
    }
  }
  for (std::size_t i = 0; i < motion.frame_count(); ++i) {
    text.append("\n").append(
        timecode_of(motion.times_s[i] - motion.times_s.front(), motion.frames_per_second));
    text.append(",").append(std::to_string(columns.size()));
    for (const int source : sources)
      text.append(",").append(source < 0 ? "0" : motion_parts::exact_text(motion.frame(i)[source]));
  }
  write_all(out, text + "\n");
}

}  // namespace phiz
