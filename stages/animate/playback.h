#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "formats/animated_mesh.h"
#include "formats/motion.h"
#include "stages/animate/living_surface.h"
#include "stages/animate/skin.h"
#include "stages/subdivide/subdivide.h"

namespace phiz {

/// Activations over time.
struct ActivationTrack {
  double frames_per_second = 60;
  std::vector<double> times_s;
  std::vector<std::vector<float>> frames;  ///< one value an activation of the layout
  std::vector<std::string> unused;         ///< curves that move nothing here: angles of head and eyes
};

/// A motion file's curves: an activation by its name, or a control (ARKit's names in any spelling) by what it
/// activates; contributions add. Throws InvalidInput for unknown names and where nothing is moved.
ActivationTrack map_activations(const FaceLayout& layout, const Motion& motion);
/// The other way: a curve an activation that is ever used (all where none is).
Motion make_activation_motion(const FaceLayout& layout, const ActivationTrack& track);

/// Expressions, controls or activations with their amounts ("smile", 0.8) as one pose. Throws InvalidInput
/// for an unknown name.
std::vector<float> pose_activations(const FaceLayout& layout,
                                    std::span<const std::pair<std::string, double>> amounts);
/// The pose comes within `ramp_s`, stays, and goes.
ActivationTrack make_pose_track(std::span<const float> pose, double seconds, double frames_per_second,
                                double ramp_s);

using ControlFrames = std::vector<std::vector<Eigen::Vector3f>>;

/// Simulates from rest: control positions after each frame. Frames that are more than 1/24 s apart take
/// several steps.
ControlFrames play(Skin& skin, const ActivationTrack& track);

struct ClipOptions {
  int level = 2;
  int most_targets = 24;  ///< morph targets, 1 .. 128
  double within_mm = 0.05;
};

struct Clip {
  AnimatedMesh mesh;
  double error_mm = 0;  ///< of any vertex in any frame
};

/// Frames as one mesh with morph targets: principal components of the moved surface, as many as keep it
/// within `within_mm`, at most most_targets.
Clip make_clip(const ControlFrames& frames, std::span<const double> times_s, LivingSurface& surface,
               const SubdivisionHierarchy& hierarchy, std::span<const Eigen::Vector2f> control_uv,
               const ClipOptions& options = {});

}  // namespace phiz
