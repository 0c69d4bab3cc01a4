#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "orchestrator/session.h"
#include "stages/animate/animate.h"

namespace phiz {

struct AnimateArguments {
  std::string subject;
  std::optional<std::string> activations, expression, solve, rig, output, level, view, anatomy, head;
  std::optional<double> fps, seconds;
  std::optional<int> width;
};

/// A fitted head and the anatomy on it.
struct AnimateScene {
  std::shared_ptr<const FaceLayout> layout;
  std::shared_ptr<const SubdivisionHierarchy> hierarchy;  ///< to level 4
  std::shared_ptr<const SurfacePlan> plan;
  std::vector<Eigen::Vector3d> control;
  std::vector<Eigen::Vector2f> control_uv;
  std::vector<std::vector<float>> displacements_mm;
  LivingSurface make_surface() const { return LivingSurface(plan, displacements_mm); }
};

/// Throws UsageError, FormatError, InvalidInput.
AnimateScene load_animate_scene(const AnimateArguments& arguments, Session& session);

/// --solve: a motion that the rig plays, as activations of the muscles; written to -o.
void solve_activations(const AnimateArguments& arguments, Session& session);
/// The other way: what the skin does, as controls of the rig; written to -o.
void solve_controls(const AnimateArguments& arguments, const AnimateScene& scene,
                    const ActivationTrack& track, Session& session);

}  // namespace phiz
