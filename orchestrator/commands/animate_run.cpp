#include "orchestrator/commands/animate_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "orchestrator/commands/rig_files.h"
#include "orchestrator/error.h"
#include "orchestrator/tasks/nouns.h"
#include "stages/deform/deform.h"
#include "stages/retarget/retarget.h"

namespace phiz {
namespace {

constexpr int kFinest = 4, kRelaxRounds = 80;

/// The rig on the subject's control vertices.
struct ControlRig {
  Deformation rig;
  NeutralSurface neutral;
  std::unique_ptr<CompiledCascade> cascade;

  ControlRig(const AnimateArguments& arguments, const AnimateScene& scene, const TemplateFiles& files,
             Session& session)
      : rig(load_rig(session, arguments.rig.value_or(""))) {
    check_same_template(rig.template_digest, files, *arguments.rig);
    const NeutralMaker maker(load_control_mesh(files), 0);
    neutral = maker.make(scene.control, scene.displacements_mm);
    cascade = std::make_unique<CompiledCascade>(rig, sample_fields(rig, maker.uv()), neutral);
  }
  void pose(std::span<const float> parameters, std::vector<Eigen::Vector3f>& positions) const {
    positions.resize(neutral.positions.size());
    cascade->evaluate(parameters, positions);
  }
};

/// What counts in a comparison: not the pocket of the mouth, not the eyes.
std::vector<float> visible_weights(const FaceLayout& layout) {
  std::vector<float> weights;
  for (const bool is_loose : layout.loose()) weights.push_back(is_loose ? 0.0f : 1.0f);
  return weights;
}

std::vector<Eigen::Vector3f> subtract(std::span<const Eigen::Vector3f> a,
                                      std::span<const Eigen::Vector3f> b) {
  std::vector<Eigen::Vector3f> result;
  for (std::size_t v = 0; v < a.size(); ++v) result.push_back(a[v] - b[v]);
  return result;
}

void write_motion(const AnimateArguments& arguments, const Motion& motion, const std::vector<double>& left,
                  const std::vector<double>& goals, Session& session) {
  double worst = 0, largest = 0, sum = 0, goal_sum = 0;
  for (std::size_t i = 0; i < left.size(); ++i) {
    worst = std::max(worst, left[i]), largest = std::max(largest, goals[i]);
    sum += left[i], goal_sum += goals[i];
  }
  std::ostringstream out;
  if (arguments.output->ends_with(".json"))
    write_motion_json(motion, out);
  else
    write_motion_csv(motion, out);
  if (!session.globals().is_dry_run) write_output_files(session, {{*arguments.output, std::move(out).str()}});
  const double frames = std::max<double>(1, static_cast<double>(left.size()));
  session.print(fmt::format(
      "{}: {} frames, {} curves, rms {:.2f} mm left of {:.2f} (worst frame {:.2f} of {:.2f})",
      *arguments.output, left.size(), motion.names.size(), sum / frames, goal_sum / frames, worst, largest));
  session.print_json({{"type", "solve"},
                      {"path", *arguments.output},
                      {"frames", left.size()},
                      {"rms_mm", sum / frames},
                      {"goal_rms_mm", goal_sum / frames},
                      {"worst_mm", worst}});
}

}  // namespace

AnimateScene load_animate_scene(const AnimateArguments& arguments, Session& session) {
  const TemplateFiles files = session.load_head(arguments.head);
  const ControlMesh generic_head = load_control_mesh(files);
  const std::filesystem::path path =
      arguments.anatomy ? std::filesystem::path(*arguments.anatomy)
                        : files.mesh_path.parent_path().parent_path() / "anatomy" / "face.json";
  std::istringstream in(read_input_file(session, path));
  FaceAnatomy anatomy;
  with_place(path.string(), [&] { anatomy = read_face_anatomy(in); });
  AnimateScene scene;
  scene.layout = std::make_shared<FaceLayout>(generic_head, anatomy);
  const HeadAsset head = load_fitted_head(session, session.open_store(), arguments.subject);
  check_same_template(head.template_digest, files, arguments.subject);
  for (const Eigen::Vector3f& p : head.positions) scene.control.push_back(p.cast<double>());
  scene.control_uv = head.uv;
  scene.displacements_mm = head.displacements_mm;
  scene.hierarchy = std::make_shared<SubdivisionHierarchy>(
      generic_head.triangles, static_cast<int>(generic_head.positions.size()), kFinest);
  scene.plan = std::make_shared<SurfacePlan>(*scene.hierarchy);
  return scene;
}

void solve_activations(const AnimateArguments& arguments, Session& session) {
  if (!arguments.rig || !arguments.output) throw UsageError("--solve needs --rig and -o FILE.csv");
  const AnimateScene scene = load_animate_scene(arguments, session);
  const ControlRig rig(arguments, scene, session.load_head(arguments.head), session);
  Motion motion = load_motion(session, *arguments.solve);
  if (arguments.fps) motion = resample_motion(motion, *arguments.fps);
  const ParameterTrack track = map_motion(rig.rig, motion);
  Skin skin(scene.layout, scene.control);
  std::vector<float> maxima;
  for (std::size_t a = 0; a < scene.layout->activations().size(); ++a)
    maxima.push_back(scene.layout->maximum(a));
  const PoseSolver solver(
      [&](std::span<const float> activations, std::vector<Eigen::Vector3f>& positions) {
        skin.reset();
        skin.set_activations(activations);
        skin.relax(kRelaxRounds);
        positions.assign(skin.positions().begin(), skin.positions().end());
      },
      maxima, visible_weights(*scene.layout));
  ActivationTrack solved{track.frames_per_second, track.times_s, {}, {}};
  std::vector<double> left, goals;
  std::vector<Eigen::Vector3f> posed;
  for (std::size_t i = 0; i < track.frame_count(); ++i) {
    session.environment().stop.throw_if_requested();
    rig.pose(track.frame(i), posed);
    const PoseSolver::Result result = solver.solve(subtract(posed, rig.neutral.positions));
    left.push_back(result.rms_mm), goals.push_back(result.goal_rms_mm);
    solved.frames.push_back(result.inputs);
  }
  write_motion(arguments, make_activation_motion(*scene.layout, solved), left, goals, session);
}

void solve_controls(const AnimateArguments& arguments, const AnimateScene& scene,
                    const ActivationTrack& track, Session& session) {
  if (!arguments.rig) throw UsageError("-o " + *arguments.output + " needs --rig");
  const ControlRig rig(arguments, scene, session.load_head(arguments.head), session);
  Skin skin(scene.layout, scene.control);
  const PoseSolver solver(
      [&](std::span<const float> controls, std::vector<Eigen::Vector3f>& positions) {
        rig.pose(parameters_of_controls(rig.rig, controls), positions);
      },
      std::vector<float>(rig.rig.controls.size(), 1.0f), visible_weights(*scene.layout));
  Motion motion;
  motion.frames_per_second = track.frames_per_second;
  motion.times_s = track.times_s;
  for (const RigControl& control : rig.rig.controls) motion.names.push_back(control.name);
  std::vector<double> left, goals;
  for (const auto& frame : play(skin, track)) {
    session.environment().stop.throw_if_requested();
    const PoseSolver::Result result = solver.solve(subtract(frame, skin.rest_positions()));
    left.push_back(result.rms_mm), goals.push_back(result.goal_rms_mm);
    motion.values.insert(motion.values.end(), result.inputs.begin(), result.inputs.end());
  }
  write_motion(arguments, motion, left, goals, session);
}

}  // namespace phiz
