#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/gltf.h"
#include "formats/image.h"
#include "formats/triangle_mesh.h"
#include "orchestrator/commands/commands.h"
#include "orchestrator/commands/export_expressions.h"
#include "orchestrator/commands/export_uv.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/object_reference.h"
#include "orchestrator/option_set.h"
#include "orchestrator/session.h"
#include "orchestrator/subject_state.h"
#include "orchestrator/tasks/head_publish.h"
#include "orchestrator/tasks/head_surface.h"
#include "orchestrator/tasks/nouns.h"
#include "store/durable_writer.h"
#include "store/error.h"

namespace phiz {
namespace {

struct ExportArguments {
  std::vector<std::string> subjects;  ///< as named on the command line: one
  std::string subject;
  std::optional<std::string> output, frame, view, rig, motion, lods, formats;
  std::optional<int> level, side;
  std::optional<int> shown_level, asset_level;
  std::optional<double> tolerance_mm;
  bool wants_texture = false, wants_confidences = false, is_all = false;

  bool has_asset_options() const { return shown_level || asset_level || tolerance_mm || wants_confidences; }
};

/// Where the head came from, by name: the digests of its inputs and of itself.
std::map<std::string, std::string> provenance_of(const ExportArguments& arguments, const Session& session,
                                                 const Store& store) {
  std::map<std::string, std::string> digests;
  for (const char* output : {"ingest/cloud.vdb", "fit_global/control.obj", "subdivide/head.glb"}) {
    std::string name = output;
    std::replace(name.begin(), name.end(), '/', '.');
    digests[name] = find_referenced_object(session, store, arguments.subject + "/" + output).digest.hex();
  }
  return digests;
}

/// The small head asset; with --tolerance 0 the store's own.
std::string make_asset(const std::string& asset, const ExportArguments& arguments, const Session& session,
                       const Store& store) {
  if (arguments.tolerance_mm == 0.0) return asset;
  HeadPublishOptions options;
  options.tolerance_mm = arguments.tolerance_mm.value_or(options.tolerance_mm);
  options.level = arguments.asset_level;
  options.shown_level = arguments.shown_level.value_or(options.shown_level);
  options.with_confidences = arguments.wants_confidences;
  options.provenance = provenance_of(arguments, session, store);
  const PublishedHead head = publish_head(asset, options);
  session.print(fmt::format("{}: levels 0 to {}, within {:.4f} mm as measured", arguments.subject, head.level,
                            head.hausdorff_mm));
  session.print_json({{"type", "head_asset"},
                      {"subject", arguments.subject},
                      {"level", head.level},
                      {"shown_level", head.shown_level},
                      {"hausdorff_mm", head.hausdorff_mm}});
  return head.bytes;
}

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

/// A plain mesh, or pictures of it.
std::string make_mesh_file(const std::string& extension, const TriangleMesh& mesh, bool in_scan_frame) {
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
  if (arguments.rig || arguments.motion || arguments.lods) {
    if (extension != ".glb" || in_scan_frame || (arguments.rig && arguments.lods) ||
        (arguments.motion && !arguments.rig))
      throw UsageError("--rig (with --motion) or --lods make a .glb in the head frame");
    if (arguments.lods) return make_lod_file(asset, *arguments.lods);
    return make_expression_file(session, asset,
                                {*arguments.rig, arguments.motion, arguments.level.value_or(2)});
  }
  if (extension == ".glb" && !in_scan_frame && !arguments.level)
    return make_asset(asset, arguments, session, store);
  if (arguments.has_asset_options())
    throw UsageError(
        "--tolerance, --asset-level, --shown-level and --confidence go with a head asset: a .glb without "
        "--level and --frame");
  return make_mesh_file(extension, evaluate_head(asset, {arguments.level, in_scan_frame}), in_scan_frame);
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

void export_file(const ExportArguments& arguments, const std::filesystem::path& path, Session& session,
                 const Store& store) {
  const std::string bytes = make_file(path.extension().string(), arguments, session, store);
  if (!session.globals().is_dry_run) write_file(session.files(), path, bytes);
  session.print(fmt::format("{}: {} bytes", path.string(), bytes.size()));
  session.print_json(
      {{"type", "export"}, {"subject", arguments.subject}, {"path", path.string()}, {"bytes", bytes.size()}});
}

/// Every subject in every format, into one folder; a subject that fails does not stop the others.
int export_all(ExportArguments arguments, Session& session, const Store& store) {
  const std::filesystem::path folder = std::filesystem::absolute(*arguments.output);
  if (!session.globals().is_dry_run) session.files().make_folders(folder);
  std::size_t failed = 0, count = 0;
  int code = kExitDone;
  for (const std::string& subject : store.list_subjects()) {
    arguments.subject = subject;
    std::istringstream words(arguments.formats.value_or("glb"));
    for (std::string word; std::getline(words, word, ',');) {
      session.environment().stop.throw_if_requested();
      ++count;
      try {
        export_file(arguments, folder / (subject + "." + word), session, store);
      } catch (...) {
        const Failure failure = describe_failure(std::current_exception());
        session.reporter().failure({subject, "export"}, failure);
        code = failure.code;
        ++failed;
      }
    }
  }
  if (count == 0) throw UsageError("the store has no subjects");
  return failed == 0 ? kExitDone : failed == count ? code : kExitSomeFailed;
}

int run_export(const ExportArguments& arguments, Session& session) {
  if (arguments.frame && arguments.frame != "head" && arguments.frame != "scan") {
    throw UsageError("--frame " + *arguments.frame + " is not head or scan");
  }
  if (arguments.is_all != arguments.subject.empty()) throw UsageError("either a SUBJECT or --all");
  if (arguments.formats && !arguments.is_all) throw UsageError("--format goes with --all");
  const Store store = session.open_store();
  if (arguments.is_all) return export_all(arguments, session, store);
  export_file(arguments, std::filesystem::absolute(*arguments.output), session, store);
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
    options.add_positionals("SUBJECT", arguments->subjects, "the subject");
    options.add_flag("--all", arguments->is_all, "every subject of the store, into a folder");
    options.add_text("--format", arguments->formats,
                     "with --all: glb (default), obj, ply, drc, exr, vdb, png; several as glb,obj");
    options.add_text("-o,--output", arguments->output, "the file; its extension says the format");
    options.require("--output");
    options.add_integer(
        "--level", arguments->level,
        "level of subdivision (default: the finest; a .glb without --level is the asset itself)");
    options.add_text("--rig", arguments->rig,
                     "into a .glb: a morph target for each expression of a rig (default level 2)");
    options.add_text("--motion", arguments->motion, "with --rig: the curves that move them");
    options.add_text("--lods", arguments->lods, "into a .glb: these levels as MSFT_lod, such as 3,2,1");
    options.add_number("--tolerance", arguments->tolerance_mm,
                       "of a head asset: its surface stays so close in mm, as measured (default 0.02; 0: the "
                       "store's own file)");
    options.add_integer("--asset-level", arguments->asset_level,
                        "of a head asset: its finest level (default: all)");
    options.add_integer(
        "--shown-level", arguments->shown_level,
        "of a head asset: what other programs show (default 2; 0: the control mesh, smallest)");
    options.add_flag("--confidence", arguments->wants_confidences, "of a head asset: keep what was measured");
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
    return [arguments](Session& session) {
      if (arguments->subjects.size() > 1) throw UsageError("one SUBJECT, or --all");
      if (!arguments->subjects.empty()) arguments->subject = arguments->subjects.front();
      return run_export(*arguments, session);
    };
  };
  return command;
}

}  // namespace phiz
