#include <algorithm>
#include <cmath>
#include <map>

#include "stages/geometry/error.h"
#include "stages/retarget/retarget.h"

namespace phiz {
namespace {

/// Names that other parts of a motion file have: angles, the head's place.
bool is_known_elsewhere(const std::string& name) {
  const auto angles = live_link_angles();
  if (std::find(angles.begin(), angles.end(), name) != angles.end()) return true;
  return !find_arkit_name(name).empty() || name.starts_with("Head");
}

/// The control of each curve, -1 where it has none.
std::vector<int> find_controls(const Deformation& rig, const Motion& motion,
                               std::vector<std::string>& unused) {
  std::vector<int> controls;
  std::map<int, std::string> taken;
  for (const std::string& name : motion.names) {
    const int control = find_control(rig, name);
    controls.push_back(control);
    if (control >= 0) {
      const auto [found, is_new] = taken.emplace(control, name);
      if (!is_new)
        throw InvalidInput("columns '" + found->second + "' and '" + name + "' are the same control");
    } else if (is_known_elsewhere(name)) {
      unused.push_back(name);
    } else {
      const std::string nearest = find_nearest_control(rig, name);
      throw InvalidInput("the rig has no control '" + name + "'" +
                         (nearest.empty() ? "" : "; the nearest is '" + nearest + "'"));
    }
  }
  if (taken.empty()) {
    const std::string& first = motion.names.front();
    const std::string nearest = find_nearest_control(rig, first);
    throw InvalidInput("no column of the motion is a control of the rig ('" + first + "'" +
                       (nearest.empty() ? ")" : "; the nearest is '" + nearest + "')"));
  }
  return controls;
}

}  // namespace

ParameterTrack map_motion(const Deformation& rig, const Motion& motion) {
  check_motion(motion);
  ParameterTrack track;
  track.parameter_count = rig.parameters.size();
  track.frames_per_second = motion.frames_per_second;
  track.times_s = motion.times_s;
  const std::vector<int> controls = find_controls(rig, motion, track.unused);
  std::map<std::string, std::size_t> index;
  for (const DeformationParameter& parameter : rig.parameters) index.emplace(parameter.name, index.size());
  std::vector<float> values(rig.controls.size());
  for (std::size_t i = 0; i < motion.frame_count(); ++i) {
    std::fill(values.begin(), values.end(), 0.0f);
    std::vector<double> sums(rig.parameters.size(), 0.0);
    for (std::size_t k = 0; k < controls.size(); ++k) {
      if (controls[k] < 0) continue;
      values[controls[k]] = motion.frame(i)[k];
      for (const auto& [name, weight] : rig.controls[controls[k]].terms)
        sums[index.at(name)] += weight * motion.frame(i)[k];
    }
    for (std::size_t k = 0; k < sums.size(); ++k)
      track.clamped_values += sums[k] < rig.parameters[k].minimum || sums[k] > rig.parameters[k].maximum;
    const std::vector<float> parameters = parameters_of_controls(rig, values);
    track.values.insert(track.values.end(), parameters.begin(), parameters.end());
  }
  return track;
}

}  // namespace phiz
