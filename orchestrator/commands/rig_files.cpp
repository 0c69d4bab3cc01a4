#include "orchestrator/commands/rig_files.h"

#include <sstream>

#include "formats/error.h"
#include "orchestrator/error.h"
#include "orchestrator/object_reference.h"
#include "orchestrator/tasks/nouns.h"
#include "store/durable_writer.h"
#include "store/error.h"

namespace phiz {
namespace {

constexpr std::uint64_t kMostBytes = std::uint64_t{4} << 30;

}  // namespace

RigPaths rig_paths(const std::string& name) {
  std::filesystem::path stem = name;
  if (stem.extension() == ".json" || stem.extension() == ".exr") stem.replace_extension();
  RigPaths paths{stem, stem};
  paths.json += ".json";
  paths.exr += ".exr";
  return paths;
}

std::string read_input_file(const Session& session, const std::filesystem::path& path) {
  try {
    return session.files().read_file(path, kMostBytes);
  } catch (const StoreError& error) {
    throw FormatError(error.what(), error.hint());
  }
}

Deformation load_rig(const Session& session, const std::string& name) {
  const RigPaths paths = rig_paths(name);
  std::istringstream json(read_input_file(session, paths.json)), exr(read_input_file(session, paths.exr));
  Deformation rig;
  with_place(paths.json.string(), [&] { rig = read_deformation(json, exr); });
  return rig;
}

Motion load_motion(const Session& session, const std::filesystem::path& path) {
  std::istringstream in(read_input_file(session, path));
  Motion motion;
  with_place(path.string(), [&] { motion = read_motion(in); });
  return motion;
}

ControlMesh load_control_mesh(const TemplateFiles& files) {
  std::istringstream mesh(files.mesh), annotations(files.annotations);
  ControlMesh head;
  with_place(files.mesh_path.string(), [&] { head = read_control_mesh(mesh, annotations); });
  return head;
}

HeadAsset load_fitted_head(const Session& session, const Store& store, const std::string& subject) {
  const std::string reference = subject + "/subdivide/head.glb";
  std::istringstream in(store.read_object(find_referenced_object(session, store, reference).digest));
  HeadAsset head;
  with_place(reference, [&] { head = read_head_asset(in); });
  return head;
}

void check_same_template(const std::string& digest, const TemplateFiles& files, const std::string& what) {
  if (digest.empty() || digest == files.digest.hex()) return;
  throw FormatError(what + " belongs to another generic head than " + files.mesh_path.string(),
                    "name its own with --template, or make it anew");
}

void write_output_files(Session& session, const std::map<std::filesystem::path, std::string>& files) {
  for (const auto& [path, bytes] : files) {
    const auto status = session.files().find_status(path);
    if (status && status->kind != FileSystem::Kind::kFile)
      throw UsageError(path.string() + ": not a regular file");
  }
  try {
    DurableWriter writer(session.files());
    for (const auto& [path, bytes] : files)
      writer.add(std::filesystem::absolute(path), std::as_bytes(std::span(bytes)),
                 FileSystem::Mode::kWritable);
    writer.publish();
  } catch (const StoreError& error) {
    if (error.fault() != StoreFault::kMissing) throw;
    throw UsageError(files.begin()->first.string() + ": no such folder");
  }
}

void save_rig(Session& session, const std::string& name, const Deformation& rig) {
  const RigPaths paths = rig_paths(name);
  std::ostringstream json, exr;
  write_deformation(rig, json, exr);
  write_output_files(session, {{paths.json, std::move(json).str()}, {paths.exr, std::move(exr).str()}});
}

}  // namespace phiz
