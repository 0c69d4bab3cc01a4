#include "orchestrator/inputs.h"

#include "formats/error.h"
#include "store/error.h"

namespace phiz {
namespace {

constexpr std::uint64_t kMaxTemplateBytes = 256 << 20;

std::string to_lower(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

/// An extension that may stand in a key; others count as none.
std::string clean_extension(const std::filesystem::path& path) {
  const std::string extension = to_lower(path.extension().string());
  if (extension.size() > 16) return {};
  for (const char c : extension) {
    if (c < '!' || c > '~') return {};
  }
  return extension;
}

void require_file(FileSystem& files, const std::filesystem::path& path) {
  const auto status = files.find_status(path);
  if (!status) throw FormatError(path.string() + ": no such file");
  if (status->kind == FileSystem::Kind::kFolder) throw FormatError(path.string() + ": a folder, not a file");
  if (status->kind != FileSystem::Kind::kFile) throw FormatError(path.string() + ": not a regular file");
  if (status->size_bytes == 0) throw FormatError(path.string() + ": the file is empty");
}

/// Failures to read an input are faults of the input, not of the store.
template <class Call>
auto with_input_faults(const Call& call) {
  try {
    return call();
  } catch (const StoreError& error) {
    throw FormatError(error.what(), error.hint());
  }
}

}  // namespace

ScanInput hash_scan(FileSystem& files, const std::filesystem::path& path, const ScanInput& known) {
  return with_input_faults([&] {
    require_file(files, path);
    ScanInput scan{path, clean_extension(path), known.digest, known.size_bytes, files.find_stamp(path)};
    if (!scan.stamp.empty() && scan.stamp == known.stamp) return scan;
    scan.size_bytes = 0;
    Sha256 hash;
    files.read_blocks(path, [&](std::span<const std::byte> block) {
      hash.update(block);
      scan.size_bytes += block.size();
    });
    scan.digest = hash.finish();
    if (!scan.stamp.empty() && files.find_stamp(path) != scan.stamp) scan.stamp.clear();
    return scan;
  });
}

std::string read_scan(FileSystem& files, const ScanInput& scan) {
  std::string bytes = with_input_faults([&] { return files.read_file(scan.path); });
  if (compute_digest(bytes) != scan.digest) {
    throw FormatError(scan.path.string() + ": the file changed while phiz worked on it",
                      "run the same command again");
  }
  return bytes;
}

TemplateFiles load_template(FileSystem& files, const std::filesystem::path& path) {
  return with_input_faults([&] {
    const auto status = files.find_status(path);
    if (!status) {
      throw FormatError(path.string() + ": no generic head there", "name one with --template FILE.obj");
    }
    const bool is_folder = status->kind == FileSystem::Kind::kFolder;
    const std::filesystem::path mesh_path =
        is_folder ? path / "head.obj" : std::filesystem::path(path).replace_extension(".obj");
    const auto annotations_path = std::filesystem::path(mesh_path).replace_extension(".json");
    require_file(files, mesh_path);
    require_file(files, annotations_path);
    return make_template(mesh_path, files.read_file(mesh_path, kMaxTemplateBytes),
                         files.read_file(annotations_path, kMaxTemplateBytes));
  });
}

TemplateFiles make_template(const std::filesystem::path& mesh_path, std::string mesh,
                            std::string annotations) {
  TemplateFiles head{mesh_path,
                     std::filesystem::path(mesh_path).replace_extension(".json"),
                     std::move(mesh),
                     std::move(annotations),
                     {},
                     {},
                     {}};
  head.mesh_digest = compute_digest(head.mesh);
  head.annotations_digest = compute_digest(head.annotations);
  Sha256 both;
  both.update(head.mesh);
  both.update(head.annotations);
  head.digest = both.finish();
  return head;
}

}  // namespace phiz
