#include "stages/animate/playback.h"

#include <algorithm>
#include <cmath>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

constexpr double kLongestStep = 1.0 / 24;

bool is_angle(const std::string& name) {
  const auto angles = live_link_angles();
  return std::any_of(angles.begin(), angles.end(), [&](std::string_view angle) { return name == angle; });
}

/// What one unit of a curve activates; null: the curve moves nothing here.
const Activations* find_curve(const FaceLayout& layout, const std::string& name, Activations& own) {
  if (layout.find_activation(name) >= 0) {
    own = {{name, 1.0}};
    return &own;
  }
  const std::string arkit = find_arkit_name(name);
  if (const Activations* found = layout.find_control(arkit.empty() ? name : arkit)) return found;
  if (!arkit.empty() || is_angle(name)) return nullptr;
  throw InvalidInput("the anatomy has no muscle, jaw motion or control '" + name + "'");
}

void add_activations(const FaceLayout& layout, const Activations& terms, double amount,
                     std::vector<float>& values) {
  for (const auto& [name, weight] : terms)
    values[layout.find_activation(name)] += static_cast<float>(weight * amount);
}

}  // namespace

ActivationTrack map_activations(const FaceLayout& layout, const Motion& motion) {
  ActivationTrack track{motion.frames_per_second, motion.times_s, {}, {}};
  std::vector<Activations> owned(motion.names.size());
  std::vector<const Activations*> curves;
  for (std::size_t k = 0; k < motion.names.size(); ++k) {
    curves.push_back(find_curve(layout, motion.names[k], owned[k]));
    if (curves.back() == nullptr) track.unused.push_back(motion.names[k]);
  }
  if (track.unused.size() == motion.names.size()) throw InvalidInput("no curve of the motion moves a muscle");
  for (std::size_t i = 0; i < motion.frame_count(); ++i) {
    std::vector<float> values(layout.activations().size(), 0.0f);
    for (std::size_t k = 0; k < curves.size(); ++k)
      if (curves[k] != nullptr) add_activations(layout, *curves[k], double{motion.frame(i)[k]}, values);
    for (std::size_t a = 0; a < values.size(); ++a)
      values[a] = std::clamp(values[a], 0.0f, layout.maximum(a));
    track.frames.push_back(std::move(values));
  }
  return track;
}

Motion make_activation_motion(const FaceLayout& layout, const ActivationTrack& track) {
  std::vector<std::size_t> used;
  for (std::size_t a = 0; a < layout.activations().size(); ++a)
    if (std::any_of(track.frames.begin(), track.frames.end(),
                    [&](const auto& frame) { return frame[a] != 0; }))
      used.push_back(a);
  if (used.empty())
    for (std::size_t a = 0; a < layout.activations().size(); ++a) used.push_back(a);
  Motion motion;
  motion.frames_per_second = track.frames_per_second;
  motion.times_s = track.times_s;
  for (const std::size_t a : used) motion.names.push_back(layout.activations()[a]);
  for (const std::vector<float>& frame : track.frames)
    for (const std::size_t a : used) motion.values.push_back(frame[a]);
  return motion;
}

std::vector<float> pose_activations(const FaceLayout& layout,
                                    std::span<const std::pair<std::string, double>> amounts) {
  std::vector<float> values(layout.activations().size(), 0.0f);
  for (const auto& [name, amount] : amounts) {
    Activations own;
    const Activations* terms = layout.find_expression(name);
    if (terms == nullptr) terms = find_curve(layout, name, own);
    if (terms != nullptr) add_activations(layout, *terms, amount, values);
  }
  for (std::size_t a = 0; a < values.size(); ++a) values[a] = std::clamp(values[a], 0.0f, layout.maximum(a));
  return values;
}

ActivationTrack make_pose_track(std::span<const float> pose, double seconds, double frames_per_second,
                                double ramp_s) {
  CONTRACT(seconds >= 0 && frames_per_second > 0 && ramp_s > 0);
  ActivationTrack track{frames_per_second, {}, {}, {}};
  const int frames = static_cast<int>(std::lround(seconds * frames_per_second));
  for (int i = 0; i <= frames; ++i) {
    const double time = i / frames_per_second;
    const double t = std::clamp(std::min(time, seconds - time) / ramp_s, 0.0, 1.0);
    const auto amount = static_cast<float>(t * t * (3 - 2 * t));
    track.times_s.push_back(time);
    track.frames.emplace_back();
    for (const float value : pose) track.frames.back().push_back(amount * value);
  }
  return track;
}

ControlFrames play(Skin& skin, const ActivationTrack& track) {
  ControlFrames frames;
  skin.reset();
  for (std::size_t i = 0; i < track.frames.size(); ++i) {
    skin.set_activations(track.frames[i]);
    const double seconds = i == 0 ? 1 / track.frames_per_second : track.times_s[i] - track.times_s[i - 1];
    const int steps = std::clamp(static_cast<int>(std::ceil(seconds / kLongestStep - 1e-9)), 1, 24);
    for (int k = 0; k < steps; ++k) skin.step(seconds / steps);
    frames.emplace_back(skin.positions().begin(), skin.positions().end());
  }
  return frames;
}

}  // namespace phiz
