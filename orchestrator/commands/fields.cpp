#include "orchestrator/commands/fields.h"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "formats/error.h"
#include "formats/muscle_file.h"
#include "orchestrator/commands/commands.h"
#include "orchestrator/commands/rig_files.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/option_set.h"
#include "orchestrator/session.h"
#include "orchestrator/tasks/nouns.h"
#include "stages/deform/muscles.h"
#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

using nlohmann::ordered_json;

struct MusclesArguments {
  std::optional<std::string> output, folder, head;
  std::optional<int> side;
};

/// rig.json and the muscles it names, from a folder.
struct MuscleFolder {
  RigFile rig;
  std::vector<MuscleFile> muscles;
};

MuscleFolder read_muscles(const Session& session, const std::filesystem::path& folder) {
  MuscleFolder read;
  const std::filesystem::path rig_path = folder / "rig.json";
  std::istringstream rig(read_input_file(session, rig_path));
  with_place(rig_path.string(), [&] { read.rig = read_rig_file(rig); });
  for (const std::string& name : read.rig.muscles) {
    const std::filesystem::path path = folder / (name + ".json");
    std::istringstream in(read_input_file(session, path));
    with_place(path.string(), [&] { read.muscles.push_back(read_muscle_file(in)); });
  }
  return read;
}

void run_muscles(const MusclesArguments& arguments, Session& session) {
  const TemplateFiles files = session.load_head(arguments.head);
  const std::filesystem::path folder = arguments.folder
                                           ? std::filesystem::path(*arguments.folder)
                                           : files.mesh_path.parent_path().parent_path() / "muscles";
  const MuscleFolder read = read_muscles(session, folder);
  MuscleOptions options;
  options.side = arguments.side.value_or(options.side);
  if (options.side < 16 || options.side > 4096) throw UsageError("--side is not from 16 to 4096");
  Deformation rig = build_muscles(load_control_mesh(files), read.muscles, read.rig, options);
  rig.template_digest = files.digest.hex();
  if (!session.globals().is_dry_run) save_rig(session, *arguments.output, rig);
  const RigPaths paths = rig_paths(*arguments.output);
  session.print(fmt::format("{}, {}: {} fields, {} controls", paths.json.string(), paths.exr.string(),
                            rig.fields.size() - 1, rig.controls.size()));
  session.print_json({{"type", "rig"},
                      {"json", paths.json.string()},
                      {"exr", paths.exr.string()},
                      {"fields", rig.fields.size() - 1},
                      {"controls", rig.controls.size()}});
}

std::string join(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text.append(text.empty() ? "" : " ").append(word);
  return text.empty() ? "-" : text;
}

void run_list(const std::string& name, Session& session) {
  const Deformation rig = load_rig(session, name);
  for (const int index : compute_cascade_order(rig)) {
    const DeformationField& field = rig.fields[index];
    session.print(fmt::format("field   {:<24} {:<9} on {:<24} {:<24} {:>3} x {:<3} {}", field.name,
                              field_type_name(field.type), join(field.inputs),
                              field.parameter.empty() ? "-" : field.parameter, field.image.width,
                              field.image.height, field.origin));
    session.print_json({{"type", "field"},
                        {"name", field.name},
                        {"field_type", field_type_name(field.type)},
                        {"on", field.inputs},
                        {"parameter", field.parameter},
                        {"gain", field.gain},
                        {"origin", field.origin}});
  }
  for (const RigControl& control : rig.controls) {
    std::vector<std::string> terms;
    for (const auto& [parameter, weight] : control.terms)
      terms.push_back(weight == 1 ? parameter : fmt::format("{} * {}", weight, parameter));
    session.print(
        fmt::format("control {:<24} {} (also {})", control.name, join(terms), join(control.aliases)));
    session.print_json({{"type", "control"},
                        {"name", control.name},
                        {"aliases", control.aliases},
                        {"terms", control.terms}});
  }
}

Command make_muscles_command() {
  Command command{"muscles", "draw designed muscles into a rig (rig.json and rig.exr)", {}, {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto arguments = std::make_shared<MusclesArguments>();
    options.add_text("-o,--output", arguments->output, "the rig: NAME.json and NAME.exr are written");
    options.require("--output");
    options.add_text("--from", arguments->folder,
                     "folder with rig.json and the muscles it names (default: phiz's own)");
    options.add_integer("--side", arguments->side, "nodes of the (u,v) grid a side (default 512)");
    options.add_text("--template", arguments->head, "the generic head's .obj, its .json beside it");
    return [arguments](Session& session) {
      with_threads(session.globals().threads.value_or(0), [&] { run_muscles(*arguments, session); });
      return int{kExitDone};
    };
  };
  return command;
}

Command make_list_command() {
  Command command{"list", "fields of a rig in the order of its cascade, and which name moves which", {}, {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto name = std::make_shared<std::string>();
    options.add_positional("RIG", *name, "rig.json, with rig.exr beside it");
    return [name](Session& session) {
      run_list(*name, session);
      return int{kExitDone};
    };
  };
  return command;
}

}  // namespace

Command make_fields_command() {
  Command command{"fields", "deformation fields: designed muscles, what a rig holds, pictures of it", {}, {}};
  command.children = {make_muscles_command(),      make_fields_learn_command(), make_fields_pca_command(),
                      make_fields_shape_command(), make_list_command(),         make_fields_show_command()};
  return command;
}

}  // namespace phiz
