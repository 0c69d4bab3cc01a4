#include "stages/synth/synth.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "orchestrator/commands/commands.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/option_set.h"
#include "orchestrator/session.h"
#include "orchestrator/tasks/nouns.h"
#include "stages/geometry/parallel.h"
#include "store/durable_writer.h"

namespace phiz {
namespace {

using nlohmann::ordered_json;

struct SynthArguments {
  std::optional<std::string> output, units, head, expression;
  std::vector<std::string> settings;
  std::optional<int> subjects, seed, points, level, rotate_seed;
  bool has_no_shoulders = false, is_generic = false;
};

double units_per_mm(const std::string& units) {
  if (units == "mm") return 1;
  if (units == "cm") return 0.1;
  if (units == "m") return 0.001;
  if (units == "in") return 1 / 25.4;
  throw UsageError("--units " + units + " is not mm, cm, m or in");
}

/// "nose_length=1.5" into the recipe.
void apply_setting(const std::string& setting, SubjectRecipe& recipe) {
  const std::size_t equals = setting.find('=');
  double value = 0;
  std::istringstream number(equals == std::string::npos ? "" : setting.substr(equals + 1));
  if (!(number >> value) || !number.eof()) throw UsageError("--set " + setting + " is not slider=number");
  recipe.sliders[setting.substr(0, equals)] = value;
}

template <class List>
void require_known(const std::string& name, const List& known, const std::string& kind) {
  std::string names;
  for (const Variation& each : known) {
    if (each.name == name) return;
    names += (names.empty() ? "" : ", ") + each.name;
  }
  throw UsageError("no " + kind + " is called '" + name + "'", "known: " + names);
}

SubjectRecipe make_recipe(const SynthArguments& arguments, std::uint64_t seed) {
  SubjectRecipe recipe;
  if (!arguments.is_generic) recipe = draw_recipe(seed);
  for (const std::string& setting : arguments.settings) apply_setting(setting, recipe);
  if (arguments.expression) recipe.expressions[*arguments.expression] = 1;
  for (const auto& [name, value] : recipe.sliders) require_known(name, list_sliders(), "slider");
  for (const auto& [name, value] : recipe.expressions) require_known(name, list_expressions(), "expression");
  return recipe;
}

std::string to_ply(const TriangleMesh& mesh) {
  std::ostringstream out;
  write_ply(mesh, out);
  return std::move(out).str();
}

/// One subject's files, by their path under the output folder, and what subjects.json says of it.
struct MadeSubject {
  std::map<std::string, std::string> files;
  ordered_json record;
};

MadeSubject make_files(const SynthArguments& arguments, const SubjectBase& base, const std::string& name,
                       std::uint64_t seed) {
  const SubjectRecipe recipe = make_recipe(arguments, seed);
  const std::vector<Eigen::Vector3d> truth = make_subject(base, recipe);
  const ScanTarget target = make_scan_target(base, truth, {!arguments.has_no_shoulders, true, seed});
  ScanOptions options;
  options.points = arguments.points.value_or(options.points);
  options.cut = make_capture_plane(140 + static_cast<double>(seed * 37 % 61), seed);
  const PointCloud cloud = scan_surface(target, options, seed);

  const std::string units = arguments.units.value_or("mm");
  Eigen::Matrix4d scan_from_truth = Eigen::Vector4d(1, 1, 1, 1).asDiagonal();
  scan_from_truth.topLeftCorner<3, 3>() *= units_per_mm(units);
  if (arguments.rotate_seed) {
    const auto pose_seed = static_cast<std::uint64_t>(*arguments.rotate_seed) + seed;
    scan_from_truth = draw_scan_pose(pose_seed, units_per_mm(units));
  }
  TriangleMesh scan, surface;
  for (const Eigen::Vector3f& point : cloud.positions) {
    scan.positions.push_back((scan_from_truth * point.cast<double>().homogeneous()).head<3>().cast<float>());
  }
  scan.colours = cloud.colours;
  surface.triangles = base.triangles;
  for (const Eigen::Vector3d& position : truth) surface.positions.push_back(position.cast<float>());

  MadeSubject made;
  const std::string scan_file = "scans/" + name + ".ply", truth_file = "truth/" + name + ".ply";
  made.files = {{scan_file, to_ply(scan)}, {truth_file, to_ply(surface)}};
  made.record = {{"seed", seed},
                 {"scan", scan_file},
                 {"points", scan.positions.size()},
                 {"triangles", 0},
                 {"units", units},
                 {"colour", true},
                 {"truth", truth_file},
                 {"scan_from_truth", to_json(scan_from_truth)},
                 {"sliders", recipe.sliders},
                 {"expressions", recipe.expressions},
                 {"irregularity_mm", recipe.irregularity_mm}};
  for (const auto& [landmark, point] : base.landmarks) {
    const Eigen::Vector3d p = position_at(point, base.triangles, truth);
    made.record["landmarks_mm"][landmark] = {p.x(), p.y(), p.z()};
  }
  return made;
}

void write_files(const std::filesystem::path& folder, const std::map<std::string, std::string>& contents,
                 Session& session) {
  DurableWriter writer(session.files());
  for (const auto& [file, bytes] : contents) {
    writer.add(folder / file, std::as_bytes(std::span(bytes)), FileSystem::Mode::kWritable);
  }
  writer.publish();
}

SubjectBase load_base(const SynthArguments& arguments, const Session& session) {
  const TemplateFiles files = session.load_head(arguments.head);
  std::istringstream mesh(files.mesh), annotations(files.annotations);
  ControlMesh head;
  with_place(files.mesh_path.string(), [&] { head = read_control_mesh(mesh, annotations); });
  return make_subject_base(head, arguments.level.value_or(3));
}

void check(const SynthArguments& arguments) {
  units_per_mm(arguments.units.value_or("mm"));
  make_recipe(arguments, 0);
  const int subjects = arguments.subjects.value_or(1), level = arguments.level.value_or(3);
  if (subjects < 1 || subjects > 10'000) throw UsageError("--subjects is not from 1 to 10000");
  if (level < 0 || level > 4) throw UsageError("--level is not from 0 to 4");
  if (arguments.seed.value_or(0) < 0) throw UsageError("--seed is negative");
  const int points = arguments.points.value_or(1000);
  if (points < 100 || points > 20'000'000) throw UsageError("--points is not from 100 to 20000000");
}

void run(const SynthArguments& arguments, Session& session) {
  const std::filesystem::path folder = std::filesystem::absolute(*arguments.output);
  const SubjectBase base = load_base(arguments, session);
  if (!session.globals().is_dry_run) {
    for (const char* part : {"scans", "truth"}) session.files().make_folders(folder / part);
  }
  ordered_json subjects;
  for (int i = 0; i < arguments.subjects.value_or(1); ++i) {
    session.environment().stop.throw_if_requested();
    const auto seed = static_cast<std::uint64_t>(arguments.seed.value_or(1) + i);
    std::string name = fmt::format("synth{:03}", seed);
    if (arguments.expression) name += "_" + *arguments.expression;
    MadeSubject made = make_files(arguments, base, name, seed);
    if (!session.globals().is_dry_run) write_files(folder, made.files, session);
    session.print((folder / made.record["scan"].get<std::string>()).string());
    ordered_json line = {{"type", "synth"}, {"subject", name}};
    line.update(made.record);
    session.print_json(line);
    subjects[name] = std::move(made.record);
  }
  const ordered_json list = {{"note",
                              "truth meshes are in mm, +y up, +z forward, +x to the subject's left; "
                              "scan point = scan_from_truth * truth point (column vectors)"},
                             {"subjects", subjects}};
  if (!session.globals().is_dry_run) write_files(folder, {{"subjects.json", list.dump(1) + "\n"}}, session);
}

}  // namespace

Command make_synth_command() {
  Command command{"synth", "make synthetic subjects and scans of them with known truth", {}, {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto arguments = std::make_shared<SynthArguments>();
    options.add_text("-o,--output", arguments->output, "folder for scans/, truth/ and subjects.json");
    options.require("--output");
    options.add_integer("--subjects", arguments->subjects, "how many (default 1); seeds count up");
    options.add_integer("--seed", arguments->seed, "of the first subject (default 1)");
    options.add_texts("--set", arguments->settings, "slider=value in standard deviations, may be repeated");
    options.add_flag("--generic", arguments->is_generic, "start from the generic head, draw no sliders");
    options.add_text("--expression", arguments->expression,
                     "jawOpen, mouthSmile, browInnerUp, mouthPucker or eyeBlink");
    options.add_integer("--points", arguments->points, "points of each scan (default 300000)");
    options.add_integer("--level", arguments->level, "subdivision level of the truth, 0 to 4 (default 3)");
    options.add_text("--units", arguments->units, "of the scan: mm (default), cm, m or in");
    options.add_integer("--rotate-seed", arguments->rotate_seed, "turn and move the scans at random");
    options.add_flag("--no-shoulders", arguments->has_no_shoulders, "end at the neck");
    options.add_text("--template", arguments->head, "the generic head's .obj, its .json beside it");
    return [arguments](Session& session) {
      check(*arguments);
      with_threads(session.globals().threads.value_or(0), [&] { run(*arguments, session); });
      return int{kExitDone};
    };
  };
  return command;
}

}  // namespace phiz
