#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/gltf.h"
#include "formats/image.h"
#include "formats/triangle_mesh.h"
#include "orchestrator/commands/commands.h"
#include "orchestrator/commands/export_uv.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/object_reference.h"
#include "orchestrator/option_set.h"
#include "orchestrator/session.h"
#include "orchestrator/subject_state.h"
#include "orchestrator/tasks/head_surface.h"
#include "orchestrator/tasks/nouns.h"
#include "store/durable_writer.h"
#include "store/error.h"

namespace phiz {
namespace {

struct ExportArguments {
  std::string subject;
  std::optional<std::string> output, frame, view;
  std::optional<int> level, side;
  bool wants_texture = false;
};

/// A sheet of pictures that `phiz fit --views` made of this very fit.
std::string read_view(const ExportArguments& arguments, const Session& session, const Store& store) {
  if (arguments.level || arguments.frame) throw UsageError("--view goes without --level and --frame");
  const Task& task = session.pipeline().get("views");
  const std::string output = *arguments.view + ".png";
  if (std::find(task.outputs.begin(), task.outputs.end(), output) == task.outputs.end()) {
    std::string names;
    for (const std::string& name : task.outputs)
      names += (names.empty() ? "" : ", ") + std::filesystem::path(name).stem().string();
    throw UsageError("there is no view '" + *arguments.view + "'", "the views are: " + names);
  }
  const SubjectRecord record = session.get_subject(store, arguments.subject);
  for (const StageState& state : compute_subject_state(store, session.pipeline(), record)) {
    if (state.stage == task.name && state.status == StageState::Status::kDone)
      return store.read_object(state.result->outputs.at(output).digest);
  }
  throw UsageError(
      "the store holds no pictures of this fit of " + arguments.subject,
      "make them: phiz fit " + record.scan_path + " --subject " + record.name + " " + task.option);
}

/// The bytes of the file, by its extension.
std::string make_file(const std::string& extension, const ExportArguments& arguments, const Session& session,
                      const Store& store) {
  if (arguments.view) {
    if (extension != ".png") throw UsageError("a view is a .png");
    return read_view(arguments, session, store);
  }
  const bool in_scan_frame = arguments.frame == "scan";
  const auto read = [&](const std::string& output) {
    return store.read_object(find_referenced_object(session, store, arguments.subject + "/" + output).digest);
  };
  if (arguments.wants_texture && extension != ".png" && extension != ".exr")
    throw UsageError("a texture is a .png or an .exr");
  if (arguments.wants_texture || extension == ".exr") {
    if (in_scan_frame || arguments.level)
      throw UsageError("what lies over (u,v) is in the head frame and at the finest level");
    PointCloud cloud;
    with_place(arguments.subject + "/cloud.vdb", [&] {
      std::istringstream in(read("ingest/cloud.vdb"));
      cloud = read_vdb_points(in);
    });
    return make_uv_file(extension, arguments.wants_texture, arguments.side, read("subdivide/head.glb"),
                        cloud);
  }
  if (arguments.side) throw UsageError("--size goes with an .exr or --texture");
  if (extension == ".vdb") {
    if (in_scan_frame || arguments.level)
      throw UsageError("a .vdb is the clean cloud in the head frame, without levels");
    return read("ingest/cloud.vdb");
  }
  const std::string asset = read("subdivide/head.glb");
  if (extension == ".glb" && !in_scan_frame && !arguments.level) return asset;
  const TriangleMesh mesh = evaluate_head(asset, {arguments.level, in_scan_frame});
  std::ostringstream out;
  if (extension == ".glb") {
    write_glb(mesh, out);
  } else if (extension == ".obj") {
    write_obj(mesh, out);
  } else if (extension == ".ply") {
    write_ply(mesh, out);
  } else if (extension == ".drc") {
    write_drc(mesh, out);
  } else if (extension == ".png") {
    if (in_scan_frame) throw UsageError("pictures are in the head frame");
    write_png(draw_head(mesh), out);
  } else {
    throw UsageError("cannot write a '" + extension + "' file",
                     "use .glb, .obj, .ply, .drc, .exr, .vdb or .png");
  }
  return std::move(out).str();
}

/// Whole or not at all; an existing file is replaced.
void write_file(FileSystem& files, const std::filesystem::path& path, const std::string& bytes) {
  const auto status = files.find_status(path);
  if (status && status->kind != FileSystem::Kind::kFile)
    throw UsageError(path.string() + ": not a regular file");
  try {
    DurableWriter writer(files);
    writer.add(path, std::as_bytes(std::span(bytes)), FileSystem::Mode::kWritable);
    writer.publish();
  } catch (const StoreError& error) {
    if (error.fault() != StoreFault::kMissing) throw;
    throw UsageError(path.string() + ": no such folder");
  }
}

int run_export(const ExportArguments& arguments, Session& session) {
  if (arguments.frame && arguments.frame != "head" && arguments.frame != "scan") {
    throw UsageError("--frame " + *arguments.frame + " is not head or scan");
  }
  const std::filesystem::path path = std::filesystem::absolute(*arguments.output);
  const Store store = session.open_store();
  const std::string bytes = make_file(path.extension().string(), arguments, session, store);
  if (!session.globals().is_dry_run) write_file(session.files(), path, bytes);
  session.print(fmt::format("{}: {} bytes", path.string(), bytes.size()));
  session.print_json(
      {{"type", "export"}, {"subject", arguments.subject}, {"path", path.string()}, {"bytes", bytes.size()}});
  return kExitDone;
}

}  // namespace

Command make_export_command() {
  Command command{
      "export",
      "write a fitted head as .glb .obj .ply .drc .png, over (u,v) as .exr, its clean cloud as .vdb, or "
      "pictures of a stage",
      {},
      {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto arguments = std::make_shared<ExportArguments>();
    options.add_positional("SUBJECT", arguments->subject, "the subject");
    options.add_text("-o,--output", arguments->output, "the file; its extension says the format");
    options.require("--output");
    options.add_integer(
        "--level", arguments->level,
        "level of subdivision (default: the finest; a .glb without --level is the asset itself)");
    options.add_text("--frame", arguments->frame,
                     "head (mm, upright; default) or scan (the scan's own frame and units)");
    options.add_flag("--texture", arguments->wants_texture,
                     "the scan's colours over (u,v): .png (sRGB) or .exr (linear)");
    options.add_integer("--size", arguments->side,
                        "of an .exr geometry image or a texture: nodes a side (default 512)");
    options.add_text(
        "--view", arguments->view,
        "into a .png: pictures of a stage beside the scan, from phiz fit --views: ingest, align, "
        "fit_local, fit_global, subdivide or closeups");
    return [arguments](Session& session) { return run_export(*arguments, session); };
  };
  return command;
}

}  // namespace phiz
