#include "formats/motion.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "formats/error.h"
#include "formats/motion_parts.h"
#include "formats/text.h"

namespace phiz {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMostFrames = 1e7;
constexpr const char* kSchema = "phiz.motion.1";

bool is_rate(double rate) {
  return rate > 0 && rate <= 1000;
}

void parse_frames(const Json& root, Motion& motion) {
  for (const Json& row : root.at("frames")) {
    const std::string place = "frames[" + std::to_string(motion.times_s.size()) + "]";
    if (!row.is_array() || row.size() != motion.names.size() + 1)
      throw FormatError("is not a list of a time and " + std::to_string(motion.names.size()) + " values (" +
                        place + ")");
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (!row[i].is_number()) throw FormatError("is not a number (" + place + ")");
      if (i == 0) motion.times_s.push_back(row[i].get<double>());
      if (i > 0) motion.values.push_back(motion_parts::to_value(row[i].get<double>(), place));
    }
  }
}

std::string text_of(double value) {
  return Json(value).dump();  // shortest text that reads back exactly
}

std::string text_of(float value) {
  return motion_parts::exact_text(value);
}

}  // namespace

void check_motion(const Motion& motion) {
  if (motion.names.empty()) throw FormatError("motion without curves");
  if (motion.times_s.empty()) throw FormatError("motion without frames");
  std::set<std::string> names;
  for (const std::string& name : motion.names) {
    if (!motion_parts::is_name(name)) throw FormatError("'" + name + "' cannot be a curve's name");
    if (!names.insert(name).second) throw FormatError("column '" + name + "' twice");
  }
  if (motion.values.size() != motion.names.size() * motion.times_s.size())
    throw FormatError("motion whose values are not of its size");
  if (!is_rate(motion.frames_per_second)) throw FormatError("frames per second not above 0, up to 1000");
  for (std::size_t i = 0; i < motion.times_s.size(); ++i) {
    if (!std::isfinite(motion.times_s[i]) || std::abs(motion.times_s[i]) > 1e9)
      throw FormatError("time is not finite (frame " + std::to_string(i) + ")");
    if (i > 0 && !(motion.times_s[i] > motion.times_s[i - 1]))
      throw FormatError("time goes back (frame " + std::to_string(i) + ")");
  }
  for (std::size_t i = 0; i < motion.values.size(); ++i) {
    if (!std::isfinite(motion.values[i]))
      throw FormatError("value of '" + motion.names[i % motion.names.size()] + "' is not finite (frame " +
                        std::to_string(i / motion.names.size()) + ")");
  }
}

Motion read_motion(std::istream& in) {
  const std::string text = read_all(in);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) throw FormatError("is empty (byte 0)");
  Motion motion = text[first] == '{' ? motion_parts::parse_json(text) : motion_parts::parse_csv(text);
  check_motion(motion);
  return motion;
}

namespace motion_parts {

Motion parse_json(const std::string& text) {
  Json root;
  try {
    root = Json::parse(text);
  } catch (const Json::parse_error& error) {
    throw FormatError("is not JSON (byte " + std::to_string(error.byte) + ")");
  } catch (const Json::exception&) {
    throw FormatError("is not JSON with numbers in range");
  }
  for (const char* key : {"schema", "frames_per_second", "names", "frames"}) {
    if (!root.contains(key)) throw FormatError("missing key '" + std::string(key) + "'");
  }
  if (root.size() != 4) throw FormatError("unknown keys");
  if (root["schema"] != kSchema) throw FormatError("is not \"" + std::string(kSchema) + "\" (schema)");
  if (!root["names"].is_array() || !root["frames"].is_array() || !root["frames_per_second"].is_number())
    throw FormatError("names or frames are no list, or frames_per_second no number");
  Motion motion;
  for (const Json& name : root["names"]) {
    if (!name.is_string()) throw FormatError("is not a text (names)");
    motion.names.push_back(name.get<std::string>());
  }
  parse_frames(root, motion);
  check_motion(motion);
  find_rate_and_gaps(motion);
  motion.frames_per_second = root["frames_per_second"].get<double>();
  return motion;
}

float to_value(double value, const std::string& place) {
  if (!(std::abs(value) <= 1e30)) throw FormatError("is not a finite number (" + place + ")");
  return static_cast<float>(value);
}

bool is_name(const std::string& name) {
  return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
    return c > ' ' && c < 127 && c != '"' && c != ',' && c != '\\';
  });
}

}  // namespace motion_parts

void write_motion_json(const Motion& motion, std::ostream& out) {
  check_motion(motion);
  std::string text = "{\"schema\": \"" + std::string(kSchema) + "\",\n \"frames_per_second\": ";
  text +=
      text_of(motion.frames_per_second) + ",\n \"names\": " + Json(motion.names).dump() + ",\n \"frames\": [";
  for (std::size_t i = 0; i < motion.frame_count(); ++i) {
    text += (i == 0 ? "\n  [" : ",\n  [") + text_of(motion.times_s[i]);
    for (const float value : motion.frame(i)) text += ", " + text_of(value);
    text += "]";
  }
  write_all(out, text + "\n ]}\n");
}

void find_rate_and_gaps(Motion& motion) {
  motion.gaps.clear();
  if (motion.frame_count() < 2) return;
  std::vector<double> steps;
  for (std::size_t i = 1; i < motion.frame_count(); ++i)
    steps.push_back(motion.times_s[i] - motion.times_s[i - 1]);
  std::vector<double> sorted = steps;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                   sorted.end());
  const double step = std::max(1e-3, sorted[sorted.size() / 2]);
  const double rate = 1 / step, whole = std::round(rate);
  motion.frames_per_second = std::min(1000.0, std::abs(rate - whole) < 0.01 * rate ? whole : rate);
  if (!(motion.frames_per_second > 0)) motion.frames_per_second = rate;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double missing = std::round(steps[i] / step) - 1;
    if (steps[i] > 1.5 * step) motion.gaps.push_back({i, static_cast<int>(std::min(missing, 1e9))});
  }
}

Motion resample_motion(const Motion& motion, double frames_per_second) {
  check_motion(motion);
  if (!is_rate(frames_per_second)) throw FormatError("frames per second not above 0, up to 1000");
  if (frames_per_second == motion.frames_per_second && motion.gaps.empty()) return motion;
  const double start = motion.times_s.front(), length = motion.times_s.back() - start;
  if (length * frames_per_second > kMostFrames)
    throw FormatError("resampled motion is longer than 10 million frames");
  Motion resampled;
  resampled.names = motion.names;
  resampled.frames_per_second = frames_per_second;
  resampled.gaps = motion.gaps;
  const auto count = static_cast<std::size_t>(std::floor(length * frames_per_second + 1e-6)) + 1;
  std::size_t before = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double time = start + static_cast<double>(i) / frames_per_second;
    while (before + 2 < motion.frame_count() && motion.times_s[before + 1] <= time) ++before;
    const std::size_t after = std::min(before + 1, motion.frame_count() - 1);
    const double span = motion.times_s[after] - motion.times_s[before];
    const double share = span > 0 ? std::clamp((time - motion.times_s[before]) / span, 0.0, 1.0) : 0;
    resampled.times_s.push_back(time);
    for (std::size_t k = 0; k < motion.names.size(); ++k) {
      const double a = motion.frame(before)[k], b = motion.frame(after)[k];
      resampled.values.push_back(static_cast<float>(a + share * (b - a)));
    }
  }
  for (MotionGap& gap : resampled.gaps) {
    const double at = (motion.times_s[gap.after_frame] - start) * frames_per_second;
    const double end = (motion.times_s[gap.after_frame + 1] - start) * frames_per_second;
    gap.after_frame = static_cast<std::size_t>(at);
    gap.missing_frames = std::max(0, static_cast<int>(std::ceil(end - 1e-6) - std::floor(at + 1e-6)) - 1);
  }
  return resampled;
}

}  // namespace phiz
