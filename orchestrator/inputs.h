#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "store/digest.h"
#include "store/file_system.h"

namespace phiz {

/// A scan as the user named it, and what its bytes are.
struct ScanInput {
  std::filesystem::path path;  ///< as given
  std::string extension;       ///< ".ply", lower case
  Digest digest;
  std::uint64_t size_bytes = 0;
  std::string stamp = {};  ///< FileSystem::find_stamp when it was hashed
};

/// Reads the file once, in blocks; not at all if its stamp is the one of `known`, whose digest it then has.
/// Throws FormatError that names the path: missing, a folder, no permission, empty.
ScanInput hash_scan(FileSystem& files, const std::filesystem::path& path, const ScanInput& known = {});

/// The bytes that were hashed. Throws FormatError if the file has changed since.
std::string read_scan(FileSystem& files, const ScanInput& scan);

/// The two files of a generic head.
struct TemplateFiles {
  std::filesystem::path mesh_path, annotations_path;
  std::string mesh, annotations;  ///< bytes of the .obj and of the .json
  Digest mesh_digest, annotations_digest;
  Digest digest;  ///< of both, mesh first: what names this generic head
};

/// `path` is the .obj, the .json beside it, or a folder with head.obj and head.json. Throws FormatError.
TemplateFiles load_template(FileSystem& files, const std::filesystem::path& path);

/// The generic head of these bytes; the paths are for messages only.
TemplateFiles make_template(const std::filesystem::path& mesh_path, std::string mesh,
                            std::string annotations);

}  // namespace phiz
