#include <algorithm>

#include "formats/motion.h"

namespace phiz {
namespace {

constexpr std::array<std::string_view, 52> kArkit = {
    "browDownLeft",      "browDownRight",      "browInnerUp",         "browOuterUpLeft",
    "browOuterUpRight",  "cheekPuff",          "cheekSquintLeft",     "cheekSquintRight",
    "eyeBlinkLeft",      "eyeBlinkRight",      "eyeLookDownLeft",     "eyeLookDownRight",
    "eyeLookInLeft",     "eyeLookInRight",     "eyeLookOutLeft",      "eyeLookOutRight",
    "eyeLookUpLeft",     "eyeLookUpRight",     "eyeSquintLeft",       "eyeSquintRight",
    "eyeWideLeft",       "eyeWideRight",       "jawForward",          "jawLeft",
    "jawOpen",           "jawRight",           "mouthClose",          "mouthDimpleLeft",
    "mouthDimpleRight",  "mouthFrownLeft",     "mouthFrownRight",     "mouthFunnel",
    "mouthLeft",         "mouthLowerDownLeft", "mouthLowerDownRight", "mouthPressLeft",
    "mouthPressRight",   "mouthPucker",        "mouthRight",          "mouthRollLower",
    "mouthRollUpper",    "mouthShrugLower",    "mouthShrugUpper",     "mouthSmileLeft",
    "mouthSmileRight",   "mouthStretchLeft",   "mouthStretchRight",   "mouthUpperUpLeft",
    "mouthUpperUpRight", "noseSneerLeft",      "noseSneerRight",      "tongueOut"};

constexpr std::array<std::string_view, 9> kAngles = {"HeadYaw",     "HeadPitch",     "HeadRoll",
                                                     "LeftEyeYaw",  "LeftEyePitch",  "LeftEyeRoll",
                                                     "RightEyeYaw", "RightEyePitch", "RightEyeRoll"};

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

}  // namespace

std::span<const std::string_view> arkit_names() {
  return kArkit;
}

std::span<const std::string_view> live_link_angles() {
  return kAngles;
}

std::string find_arkit_name(const std::string& name) {
  if (name.empty()) return {};
  std::string wanted = name;
  wanted[0] = lower(wanted[0]);
  if (wanted.ends_with("_L")) wanted.replace(wanted.size() - 2, 2, "Left");
  if (wanted.ends_with("_R")) wanted.replace(wanted.size() - 2, 2, "Right");
  const auto found = std::find(kArkit.begin(), kArkit.end(), wanted);
  return found == kArkit.end() ? std::string() : std::string(*found);
}

}  // namespace phiz
