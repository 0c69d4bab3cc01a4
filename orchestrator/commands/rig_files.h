#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "formats/control_mesh.h"
#include "formats/deformation.h"
#include "formats/head_asset.h"
#include "formats/motion.h"
#include "orchestrator/session.h"

namespace phiz {

/// "rig", "rig.json" and "rig.exr" all name the pair rig.json, rig.exr.
struct RigPaths {
  std::filesystem::path json, exr;
};
RigPaths rig_paths(const std::string& name);

/// The file's bytes. Throws FormatError that names the path.
std::string read_input_file(const Session& session, const std::filesystem::path& path);

/// Throw FormatError that names the file.
Deformation load_rig(const Session& session, const std::string& name);
Motion load_motion(const Session& session, const std::filesystem::path& path);
ControlMesh load_control_mesh(const TemplateFiles& files);
/// A fitted head of the store (UsageError where there is none); `bytes` are those of its head.glb.
HeadAsset load_fitted_head(const Session& session, const Store& store, const std::string& subject);

/// FormatError where rig or head belong to another generic head.
void check_same_template(const std::string& digest, const TemplateFiles& files, const std::string& what);

/// All of them or none: temporary files, then renames. An existing file is replaced. Throws UsageError where
/// the folder is missing.
void write_output_files(Session& session, const std::map<std::filesystem::path, std::string>& files);
void save_rig(Session& session, const std::string& name, const Deformation& rig);

}  // namespace phiz
