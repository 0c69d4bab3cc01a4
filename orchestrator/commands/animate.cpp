#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/image.h"
#include "orchestrator/commands/animate_run.h"
#include "orchestrator/commands/commands.h"
#include "orchestrator/commands/rig_files.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/option_set.h"
#include "orchestrator/session.h"
#include "stages/geometry/normals.h"
#include "stages/publish/views.h"

namespace phiz {
namespace {

constexpr double kRampSeconds = 0.3;
constexpr int kFinest = 4;

/// "smile=0.8,jawOpen=0.3"; a name alone is 1.
std::vector<std::pair<std::string, double>> parse_amounts(const std::string& text) {
  std::vector<std::pair<std::string, double>> amounts;
  std::istringstream words(text);
  for (std::string word; std::getline(words, word, ',');) {
    const std::size_t equals = word.find('=');
    double amount = 1;
    if (equals != std::string::npos) {
      std::istringstream number(word.substr(equals + 1));
      number.imbue(std::locale::classic());
      if (!(number >> amount) || !number.eof() || !(std::abs(amount) <= 10))
        throw UsageError("--expression: '" + word + "' is not NAME=NUMBER");
    }
    if (equals == 0 || word.empty()) throw UsageError("--expression: '" + word + "' has no name");
    amounts.emplace_back(word.substr(0, equals), amount);
  }
  if (amounts.empty()) throw UsageError("--expression names nothing");
  return amounts;
}

/// What the command is about: one of --activations, --expression.
ActivationTrack make_track(const AnimateArguments& arguments, const FaceLayout& layout, Session& session) {
  if (arguments.expression.has_value() == arguments.activations.has_value())
    throw UsageError("either --activations FILE or --expression NAME=AMOUNT,...");
  const double fps = arguments.fps.value_or(60);
  if (!(fps > 0 && fps <= 1000)) throw UsageError("--fps is not in (0, 1000]");
  if (arguments.expression) {
    const double seconds = arguments.seconds.value_or(2);
    if (!(seconds > 0 && seconds <= 600)) throw UsageError("--seconds is not in (0, 600]");
    return make_pose_track(pose_activations(layout, parse_amounts(*arguments.expression)), seconds, fps,
                           kRampSeconds);
  }
  Motion motion = load_motion(session, *arguments.activations);
  if (arguments.fps) motion = resample_motion(motion, fps);
  return map_activations(layout, motion);
}

int parse_level(const AnimateArguments& arguments) {
  const std::string level = arguments.level.value_or("2");
  if (level == "auto") return -1;
  if (level.size() != 1 || level[0] < '0' || level[0] > '0' + kFinest)
    throw UsageError("--level " + level + " is not auto or from 0 to 4");
  return level[0] - '0';
}

/// Plays every frame at the level that fits the frame time; the finest that mostly did.
int choose_level(const ControlFrames& frames, double fps, LivingSurface& surface, Session& session) {
  LevelChooser chooser(kFinest);
  std::vector<int> counts(kFinest + 1, 0);
  for (const auto& frame : frames) {
    const int level = chooser.choose(1 / fps);
    const auto start = std::chrono::steady_clock::now();
    surface.evaluate(frame, level);
    chooser.record(level, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    ++counts[level];
  }
  int best = 0;
  for (int k = 0; k <= kFinest; ++k)
    if (2 * counts[k] >= static_cast<int>(frames.size())) best = k;
  session.print(fmt::format("level {} fits {:.1f} ms a frame on this machine", best, 1e3 / fps));
  return best;
}

Eigen::AlignedBox3f face_box(const std::vector<Eigen::Vector3f>& control) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : control) box.extend(p);
  // The face: the front of the head, down to a little below the chin.
  return {Eigen::Vector3f(box.min().x(), box.min().y() * 0.8f, 0),
          Eigen::Vector3f(box.max().x(), box.max().y() * 0.85f, box.max().z())};
}

void write_pictures(const AnimateArguments& arguments, const AnimateScene& scene, const ControlFrames& frames,
                    int level, Session& session) {
  const std::filesystem::path folder = std::filesystem::absolute(*arguments.output);
  session.files().make_folders(folder);
  const auto camera = find_camera(arguments.view.value_or("front"));
  if (!camera)
    throw UsageError("there is no view '" + *arguments.view + "'", "front, side, threequarter and the like");
  LivingSurface surface = scene.make_surface();
  TriangleMesh mesh;
  mesh.triangles = scene.hierarchy->triangles(level);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    session.environment().stop.throw_if_requested();
    surface.evaluate(frames[i], level);
    mesh.positions.clear();
    for (const Point4& p : surface.positions()) mesh.positions.emplace_back(p.x, p.y, p.z);
    mesh.normals = compute_vertex_normals(mesh.positions, mesh.triangles);
    ViewOptions options;
    options.camera = *camera;
    options.width = arguments.width.value_or(480);
    options.height = options.width * 6 / 5;
    options.frame_mm = face_box(frames.front());
    std::ostringstream out;
    write_png(render_mesh(mesh, options), out);
    write_output_files(session, {{folder / fmt::format("frame_{:05}.png", i), std::move(out).str()}});
  }
}

void write_clip(const AnimateArguments& arguments, const AnimateScene& scene, const ControlFrames& frames,
                const ActivationTrack& track, int level, Session& session) {
  LivingSurface surface = scene.make_surface();
  ClipOptions options;
  options.level = level;
  const Clip clip = make_clip(frames, track.times_s, surface, *scene.hierarchy, scene.control_uv, options);
  std::ostringstream out;
  write_animated_glb(clip.mesh, out);
  write_output_files(session, {{*arguments.output, std::move(out).str()}});
  session.print(fmt::format("{}: level {}, {} frames, {} morph targets, within {:.3f} mm", *arguments.output,
                            level, frames.size(), clip.mesh.targets.size(), clip.error_mm));
  session.print_json({{"type", "clip"},
                      {"path", *arguments.output},
                      {"level", level},
                      {"frames", frames.size()},
                      {"targets", clip.mesh.targets.size()},
                      {"error_mm", clip.error_mm}});
}

void run_simulation(const AnimateArguments& arguments, Session& session) {
  AnimateScene scene = load_animate_scene(arguments, session);
  const ActivationTrack track = make_track(arguments, *scene.layout, session);
  if (!track.unused.empty())
    session.reporter().note({arguments.subject, "animate"},
                            fmt::format("nothing here moves with: {}", fmt::join(track.unused, " ")));
  const std::string extension = std::filesystem::path(arguments.output.value_or("")).extension().string();
  if (extension == ".csv" || extension == ".json") return solve_controls(arguments, scene, track, session);
  int level = parse_level(arguments);
  Skin skin(scene.layout, scene.control);
  const auto start = std::chrono::steady_clock::now();
  const ControlFrames frames = play(skin, track);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  LivingSurface surface = scene.make_surface();
  if (level < 0) level = choose_level(frames, track.frames_per_second, surface, session);
  double farthest = 0;
  for (const auto& frame : frames)
    for (std::size_t v = 0; v < frame.size(); ++v)
      farthest = std::max(farthest, static_cast<double>((frame[v] - skin.rest_positions()[v]).norm()));
  session.print(fmt::format("{}: {} frames, {:.0f} a second, farthest way {:.2f} mm", arguments.subject,
                            frames.size(), static_cast<double>(frames.size()) / std::max(seconds, 1e-9),
                            farthest));
  session.print_json({{"type", "animate"},
                      {"subject", arguments.subject},
                      {"frames", frames.size()},
                      {"seconds", seconds},
                      {"farthest_mm", farthest}});
  if (!arguments.output || session.globals().is_dry_run) return;
  if (extension == ".glb") return write_clip(arguments, scene, frames, track, level, session);
  if (!extension.empty())
    throw UsageError("-o " + *arguments.output + " is not .glb, .csv, .json or a folder for .png");
  write_pictures(arguments, scene, frames, level, session);
}

}  // namespace

Command make_animate_command() {
  Command command{"animate",
                  "muscles and skin on a fitted head: animated .glb, pictures, motions solved both ways",
                  {},
                  {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto arguments = std::make_shared<AnimateArguments>();
    options.add_positional("SUBJECT", arguments->subject, "fitted head of the store");
    options.add_text("--activations", arguments->activations,
                     "motion of muscles and jaw, or of ARKit's names");
    options.add_text("--expression", arguments->expression,
                     "smile=0.8,jawOpen=0.2: expressions, muscles, ARKit's names");
    options.add_text("--solve", arguments->solve,
                     "motion played by the rig: find the muscles for it (-o .csv)");
    options.add_text("--rig", arguments->rig,
                     "rig.json, for --solve, or for -o .csv: its controls for the muscles");
    options.add_text("-o,--output", arguments->output,
                     ".glb, a folder for .png frames, or .csv/.json; without it figures");
    options.add_text("--level", arguments->level,
                     "level of subdivision, 0 to 4 (default 2), or auto: what the machine can");
    options.add_number("--fps", arguments->fps, "frames a second (default 60, or the motion's)");
    options.add_number("--seconds", arguments->seconds, "length of an expression's clip (default 2)");
    options.add_text("--view", arguments->view, "of .png frames: front (default), threequarter ...");
    options.add_integer("--width", arguments->width, "pixels of .png frames (default 480)");
    options.add_text("--anatomy", arguments->anatomy, "face.json (default: the one beside the generic head)");
    options.add_text("--template", arguments->head, "the generic head's .obj, its .json beside it");
    return [arguments](Session& session) {
      if (arguments->width && (*arguments->width < 16 || *arguments->width > 4000))
        throw UsageError("--width is not from 16 to 4000");
      if (arguments->solve)
        solve_activations(*arguments, session);
      else
        run_simulation(*arguments, session);
      return int{kExitDone};
    };
  };
  return command;
}

}  // namespace phiz
