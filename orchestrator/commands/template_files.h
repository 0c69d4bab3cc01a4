#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "formats/control_mesh.h"
#include "formats/image.h"
#include "orchestrator/session.h"
#include "stages/template/check.h"

namespace phiz {

/// The generic head at `path`: the .obj, the .json beside it, or a folder with head.obj and head.json; by
/// default the one in use ($PHIZ_TEMPLATE, else the program's own). Throws FormatError.
ControlMesh read_generic_head(const std::optional<std::string>& path, const Session& session);

/// Prints one line, or one JSON object, a check; `folder` is where their pictures are, or empty. Throws
/// FormatError that names the first check that falls short, with `name` in front.
void report_checks(const std::vector<HeadCheck>& checks, const std::string& name,
                   const std::filesystem::path& folder, const Session& session);

/// Checks the head, prints the checks and writes head.obj and head.json into the folder, which is made where
/// it is missing. If a check falls short the files are written only with `is_forced`, and FormatError is
/// thrown.
void deliver_head(const ControlMesh& head, const std::string& folder, bool is_forced, Session& session);

/// Whole files, by name, in a folder that is made where it is missing. Nothing with --dry-run.
void write_folder(const std::filesystem::path& folder, const std::map<std::string, std::string>& contents,
                  const Session& session);

/// Name (list_check_pictures, and `sides` for the head as a whole) -> picture, for the checks that were made.
/// A second or two.
std::map<std::string, Image> draw_check_pictures(const ControlMesh& head,
                                                 const std::vector<HeadCheck>& checks);

}  // namespace phiz
