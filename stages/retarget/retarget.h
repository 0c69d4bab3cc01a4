#pragma once

#include <span>
#include <string>
#include <vector>

#include "formats/animated_mesh.h"
#include "formats/deformation.h"
#include "formats/motion.h"
#include "stages/deform/deform.h"
#include "stages/retarget/track.h"

namespace phiz {

/// A rig's parameters over time.
struct ParameterTrack {
  std::size_t parameter_count = 0;
  double frames_per_second = 60;
  std::vector<double> times_s;
  std::vector<float> values;        ///< [frame * parameter_count + parameter], within the parameters' ranges
  std::vector<std::string> unused;  ///< curves that have no control: angles of head and eyes, names of the 52
  std::size_t clamped_values = 0;   ///< beyond a parameter's range

  std::size_t frame_count() const { return times_s.size(); }
  std::span<const float> frame(std::size_t i) const {
    return {values.data() + i * parameter_count, parameter_count};
  }
};

/// Curves to controls by name or alias, controls to parameters. Throws InvalidInput for a name that is
/// neither a control nor known from elsewhere (with the nearest one), for a curve that two columns give, and
/// where no curve answers to any control.
ParameterTrack map_motion(const Deformation& rig, const Motion& motion);

/// What a subject's animation comes to, without keeping it.
struct MotionFigures {
  std::size_t frames = 0;
  double largest_mm = 0;  ///< any vertex in any frame, from neutral
  std::size_t largest_frame = 0;
  double mean_mm = 0;  ///< over vertices and frames
};

/// Plays all frames on one subject. One buffer; one thread; the same numbers on every machine.
MotionFigures measure_motion(const CompiledCascade& cascade, const NeutralSurface& neutral,
                             const ParameterTrack& track);

/// Subject and rig as one mesh with a morph target for each parameter that the track uses, at value 1, and
/// its weights over time. Targets add up linearly: exact for what the cascade adds, a chord for what it
/// turns.
AnimatedMesh make_animated_mesh(const CompiledCascade& cascade, const NeutralSurface& neutral,
                                const Deformation& rig, const ParameterTrack& track,
                                const std::vector<Eigen::Vector3i>& triangles);

/// A morph target for each of the rig's controls at 1, under its name (ARKit's, where the rig has them),
/// without moves below 0.01 mm; with a motion also its curves as weights. Throws InvalidInput as map_motion
/// does.
AnimatedMesh make_expression_mesh(const CompiledCascade& cascade, const NeutralSurface& neutral,
                                  const Deformation& rig, const Motion* motion,
                                  const std::vector<Eigen::Vector3i>& triangles);

/// Largest distance in mm between the cascade and the morph targets over the track's frames.
double measure_morph_error(const CompiledCascade& cascade, const AnimatedMesh& mesh,
                           const ParameterTrack& track);

}  // namespace phiz
