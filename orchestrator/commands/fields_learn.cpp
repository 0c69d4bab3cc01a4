#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/muscle_file.h"
#include "orchestrator/commands/fields.h"
#include "orchestrator/commands/rig_files.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/object_reference.h"
#include "orchestrator/option_set.h"
#include "orchestrator/session.h"
#include "orchestrator/tasks/nouns.h"
#include "orchestrator/work_journal.h"
#include "stages/deform/learn.h"
#include "stages/deform/muscles.h"
#include "stages/geometry/parallel.h"
#include "stages/ingest/ingest.h"

namespace phiz {
namespace {

struct LearnArguments {
  std::optional<std::string> neutral, output, axes, muscles, head;
  std::vector<std::string> expressions;
  std::optional<int> side;
  std::optional<double> noise_mm;
  bool is_symmetric = false, is_split = false;
};

/// The expressions in the order given: name and scan.
std::vector<std::pair<std::string, std::filesystem::path>> parse_expressions(
    const std::vector<std::string>& words) {
  std::vector<std::pair<std::string, std::filesystem::path>> expressions;
  for (const std::string& word : words) {
    const std::size_t at = word.find('=');
    if (at == 0 || at == std::string::npos || at + 1 == word.size())
      throw UsageError("--expression " + word + " is not NAME=SCAN", "for instance jawOpen=jaw.ply");
    const std::string name = word.substr(0, at);
    for (const auto& [known, path] : expressions)
      if (known == name) throw UsageError("two scans for the expression '" + name + "'");
    expressions.emplace_back(name, word.substr(at + 1));
  }
  return expressions;
}

constexpr const char* kVersion = "learn 1";  ///< raised whenever the same input gives other displacements

/// What an expression is learned with, beside its scan: two runs that agree here may share their steps.
std::string describe_work(const LearnArguments& arguments, const TemplateFiles& files,
                          const std::string& head_digest, double noise_mm, const Session& session) {
  std::string text = std::string(kVersion) + "\n" + files.digest.hex() + "\n" + head_digest + "\n" +
                     fmt::format("noise {}", noise_mm);
  std::vector<std::filesystem::path> sources;
  if (!arguments.muscles) {
    const std::filesystem::path folder = files.mesh_path.parent_path().parent_path() / "muscles";
    if (session.files().find_status(folder / "rig.json")) {
      for (const std::string& name : session.files().list_folder(folder)) {
        if (name.ends_with(".json")) sources.push_back(folder / name);
      }
    }
  } else if (*arguments.muscles != "none") {
    const RigPaths paths = rig_paths(*arguments.muscles);
    sources = {paths.json, paths.exr};
  }
  for (const std::filesystem::path& source : sources)
    text += "\n" + compute_digest(read_input_file(session, source)).hex();
  return text;
}

/// A rig of designed muscles that gives the fit its first guess: the one named, or the muscles that came with
/// the generic head, or none.
std::optional<Deformation> load_muscles(const LearnArguments& arguments, const TemplateFiles& files,
                                        const ControlMesh& head, Session& session) {
  if (arguments.muscles == "none") return std::nullopt;
  if (arguments.muscles) {
    Deformation rig = load_rig(session, *arguments.muscles);
    check_same_template(rig.template_digest, files, *arguments.muscles);
    return rig;
  }
  const std::filesystem::path folder = files.mesh_path.parent_path().parent_path() / "muscles";
  if (!session.files().find_status(folder / "rig.json")) {
    session.reporter().note(
        {}, "no designed muscles beside the generic head: wide open mouths will not be found");
    return std::nullopt;
  }
  RigFile rig;
  std::vector<MuscleFile> muscles;
  std::istringstream text(read_input_file(session, folder / "rig.json"));
  with_place((folder / "rig.json").string(), [&] { rig = read_rig_file(text); });
  for (const std::string& name : rig.muscles) {
    const std::filesystem::path path = folder / (name + ".json");
    std::istringstream muscle(read_input_file(session, path));
    with_place(path.string(), [&] { muscles.push_back(read_muscle_file(muscle)); });
  }
  return build_muscles(head, muscles, rig);
}

void tell(const Session& session, const std::string& name, const LearnedExpression& learned) {
  double largest = 0;
  for (const Eigen::Vector3d& d : learned.displacements_mm) largest = std::max(largest, d.norm());
  const double turned_deg =
      Eigen::AngleAxisd(learned.scan_from_neutral.linear()).angle() * 180 / 3.14159265358979;
  const double shifted_mm = learned.scan_from_neutral.translation().norm();
  session.print(fmt::format(
      "{}: moves up to {:.1f} mm, {:.3f} mm from its scan; head turned {:.2f} degrees, shifted {:.2f} mm",
      name, largest, learned.mean_distance_mm, turned_deg, shifted_mm));
  session.print_json({{"type", "expression"},
                      {"name", name},
                      {"largest_mm", largest},
                      {"distance_mm", learned.mean_distance_mm},
                      {"head_turned_deg", turned_deg},
                      {"head_shifted_mm", shifted_mm},
                      {"muscles", learned.muscles}});
}

void run_learn(const LearnArguments& arguments, Session& session) {
  FieldOptions options;
  options.side = arguments.side.value_or(options.side);
  options.is_symmetric = arguments.is_symmetric;
  options.is_split = arguments.is_split;
  const std::string axes = arguments.axes.value_or("local");
  if (axes != "local" && axes != "head") throw UsageError("--axes " + axes + " is not local or head");
  options.axes = axes == "head" ? FieldAxes::kHead : FieldAxes::kLocal;
  if (options.side < 16 || options.side > 4096) throw UsageError("--side is not from 16 to 4096");
  LearnOptions fit;
  fit.noise_mm = arguments.noise_mm.value_or(fit.noise_mm);
  if (!(fit.noise_mm >= 0 && fit.noise_mm <= 100)) throw UsageError("--noise is not from 0 to 100");
  const auto expressions = parse_expressions(arguments.expressions);
  if (expressions.empty())
    throw UsageError("no expression named", "--expression NAME=SCAN, as often as wanted");

  const TemplateFiles files = session.load_head(arguments.head);
  const ControlMesh head = load_control_mesh(files);
  const Store store = session.open_store();
  const HeadAsset neutral = load_fitted_head(session, store, *arguments.neutral);
  check_same_template(neutral.template_digest, files, *arguments.neutral);
  const std::optional<Deformation> muscles = load_muscles(arguments, files, head, session);
  const ExpressionLearner learner(head, neutral, muscles ? &*muscles : nullptr, fit);
  const std::string reference = *arguments.neutral + "/subdivide/head.glb";
  WorkJournal journal(
      store, describe_work(arguments, files, find_referenced_object(session, store, reference).digest.hex(),
                           fit.noise_mm, session));
  std::map<std::string, std::vector<Eigen::Vector3d>> displacements;
  for (const auto& [name, path] : expressions) {
    const IngestResult scan = ingest(read_scan_file(path), head);
    JournalSteps steps(journal, hash_scan(session.files(), path).digest.hex());
    const LearnedExpression learned =
        learner.learn(scan.cloud, session.globals().is_dry_run ? nullptr : &steps);
    tell(session, name, learned);
    displacements[name] = learned.displacements_mm;
    session.environment().stop.throw_if_requested();
  }
  const Deformation rig =
      make_learned_rig(head, neutral, displacements, "captured: " + *arguments.neutral, options);
  if (!session.globals().is_dry_run) save_rig(session, *arguments.output, rig);
  if (!session.globals().is_dry_run) journal.forget();
  const RigPaths paths = rig_paths(*arguments.output);
  session.print(
      fmt::format("{}, {}: {} fields", paths.json.string(), paths.exr.string(), rig.fields.size() - 1));
  session.print_json({{"type", "rig"},
                      {"json", paths.json.string()},
                      {"exr", paths.exr.string()},
                      {"fields", rig.fields.size() - 1},
                      {"controls", rig.controls.size()}});
}

}  // namespace

Command make_fields_learn_command() {
  Command command{"learn", "learn expressions from scans of a fitted subject into a rig", {}, {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto arguments = std::make_shared<LearnArguments>();
    options.add_text("--neutral", arguments->neutral, "the fitted subject whose expressions these are");
    options.require("--neutral");
    options.add_texts("--expression", arguments->expressions, "NAME=SCAN, as often as wanted");
    options.add_text("-o,--output", arguments->output, "the rig: NAME.json and NAME.exr are written");
    options.require("--output");
    options.add_text("--axes", arguments->axes,
                     "local (carried by each subject's local frames; default) or head (added as they are)");
    options.add_flag("--symmetric", arguments->is_symmetric,
                     "the mean of each expression and its mirror image");
    options.add_flag("--split", arguments->is_split, "NameLeft and NameRight instead of both sides together");
    options.add_text("--muscles", arguments->muscles,
                     "rig of designed muscles for the first guess, or none (default: phiz's own)");
    options.add_number("--noise", arguments->noise_mm, "motions below so many mm fade out (default 0.5)");
    options.add_integer("--side", arguments->side, "nodes of the (u,v) grid a side (default 512)");
    options.add_text("--template", arguments->head, "the generic head's .obj, its .json beside it");
    return [arguments](Session& session) {
      with_threads(session.globals().threads.value_or(0), [&] { run_learn(*arguments, session); });
      return int{kExitDone};
    };
  };
  return command;
}

}  // namespace phiz
