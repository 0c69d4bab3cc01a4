#include "stages/template/template.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/error.h"
#include "formats/head_asset.h"
#include "formats/scan_file.h"
#include "orchestrator/commands/commands.h"
#include "orchestrator/commands/template_files.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/object_reference.h"
#include "orchestrator/option_set.h"
#include "orchestrator/tasks/nouns.h"
#include "stages/geometry/parallel.h"
#include "stages/template/average.h"

namespace phiz {
namespace {

struct CheckArguments {
  std::string head;
  std::optional<std::string> pictures;
};

struct BuildArguments {
  std::string layout;
  std::optional<std::string> reference, head, output;
  bool is_forced = false;
};

struct AverageArguments {
  std::vector<std::string> subjects;
  std::optional<std::string> head, output;
  bool is_forced = false;
};

void run_check(const CheckArguments& arguments, Session& session) {
  const ControlMesh head = read_generic_head(arguments.head, session);
  const std::vector<HeadCheck> checks = check_generic_head(head);
  const std::filesystem::path folder = arguments.pictures.value_or("");
  if (!folder.empty()) {
    std::map<std::string, std::string> files;
    for (const auto& [name, picture] : draw_check_pictures(head, checks)) {
      std::ostringstream png;
      write_png(picture, png);
      files[name + ".png"] = std::move(png).str();
    }
    write_folder(folder, files, session);
  }
  report_checks(checks, arguments.head, folder, session);
}

Layout read_layout(const std::string& path, const Session& session) {
  std::istringstream text(read_scan(session.files(), hash_scan(session.files(), path)));
  Layout layout;
  with_place(path, [&] { layout = parse_layout(text); });
  return layout;
}

/// The surface that the layout is laid on.
MappedSurface map_surface(const BuildArguments& arguments, const Layout& layout, const Session& session) {
  if (arguments.head) return map_head(read_generic_head(arguments.head, session));
  const std::string& path = *arguments.reference;
  const std::string bytes = read_scan(session.files(), hash_scan(session.files(), path));
  ScanFile reference;
  with_place(path, [&] {
    reference = parse_scan(std::as_bytes(std::span(bytes)), std::filesystem::path(path).extension().string());
    if (reference.triangles.empty()) throw FormatError("has no triangles");
  });
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3f& p : reference.points.positions)
    positions.push_back(reference.origin + p.cast<double>());
  return map_reference(positions, reference.triangles, layout);
}

void run_build(const BuildArguments& arguments, Session& session) {
  if (arguments.reference.has_value() == arguments.head.has_value())
    throw UsageError("what the layout is laid on: either --reference MESH or --head HEAD.obj");
  const Layout layout = read_layout(arguments.layout, session);
  deliver_head(build_generic_head(layout, map_surface(arguments, layout, session)), *arguments.output,
               arguments.is_forced, session);
}

std::vector<Eigen::Vector3d> read_subject(const std::string& subject, const std::string& template_digest,
                                          const Session& session, const Store& store) {
  const std::string place = subject + "/subdivide/head.glb";
  std::istringstream bytes(store.read_object(find_referenced_object(session, store, place).digest));
  HeadAsset asset;
  with_place(place, [&] { asset = read_head_asset(bytes); });
  if (asset.template_digest != template_digest) {
    throw UsageError(subject + " was fitted with another generic head",
                     "fit it again: phiz fit ... --template HEAD.obj");
  }
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3f& p : asset.positions) positions.push_back(p.cast<double>());
  return positions;
}

void run_average(const AverageArguments& arguments, Session& session) {
  const ControlMesh head = read_generic_head(arguments.head, session);
  const std::string digest = session.load_head(arguments.head).digest.hex();
  const Store store = session.open_store();
  std::vector<std::string> names = arguments.subjects;
  if (names.empty()) names = store.list_subjects();
  std::vector<std::vector<Eigen::Vector3d>> subjects;
  for (const std::string& name : names) subjects.push_back(read_subject(name, digest, session, store));
  const ControlMesh mean = average_heads(head, subjects);
  double sum = 0, most = 0;
  for (std::size_t v = 0; v < mean.positions.size(); ++v) {
    const double distance = (mean.positions[v] - head.positions[v]).norm();
    sum += distance, most = std::max(most, distance);
  }
  deliver_head(mean, *arguments.output, arguments.is_forced, session);
  const double moved = sum / static_cast<double>(mean.positions.size());
  session.print(fmt::format("{} subjects; vertices moved by {:.3f} mm on the average, {:.3f} mm at most",
                            subjects.size(), moved, most));
  session.print_json({{"type", "average"},
                      {"subjects", subjects.size()},
                      {"mean_move_mm", moved},
                      {"largest_move_mm", most}});
}

template <class Arguments>
Command::Action make_action(std::shared_ptr<Arguments> arguments, void (*run)(const Arguments&, Session&)) {
  return [arguments, run](Session& session) {
    with_threads(session.globals().threads.value_or(0), [&] { run(*arguments, session); });
    return int{kExitDone};
  };
}

void declare_output(OptionSet& options, std::optional<std::string>& output, bool& is_forced) {
  options.add_text("-o,--output", output, "folder for head.obj and head.json");
  options.require("--output");
  options.add_flag("--force", is_forced, "write the head even if checks fall short");
}

}  // namespace

Command make_template_command() {
  Command check{"check", "measure every promise of a generic head", {}, {}};
  check.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto arguments = std::make_shared<CheckArguments>();
    options.add_positional("HEAD", arguments->head, "the .obj, its .json beside it");
    options.add_text("-o,--output", arguments->pictures, "folder for a picture of each check");
    return make_action(arguments, run_check);
  };
  Command build{"build", "make a generic head from a layout", {}, {}};
  build.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto arguments = std::make_shared<BuildArguments>();
    options.add_positional("LAYOUT", arguments->layout, "the authored source: points, curves, annotations");
    options.add_text("--reference", arguments->reference, "a symmetric head mesh in mm, upright, eyes open");
    options.add_text("--head", arguments->head, "instead: the .obj of a generic head");
    declare_output(options, arguments->output, arguments->is_forced);
    return make_action(arguments, run_build);
  };
  Command average{"average", "give a generic head the mean shape of fitted subjects", {}, {}};
  average.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto arguments = std::make_shared<AverageArguments>();
    options.add_positionals("SUBJECT", arguments->subjects, "subjects in the store (default: all)");
    options.add_text("--template", arguments->head, "the generic head they were fitted with");
    declare_output(options, arguments->output, arguments->is_forced);
    return make_action(arguments, run_average);
  };
  return {"template", "make and check generic heads", {}, {check, build, average}};
}

}  // namespace phiz
