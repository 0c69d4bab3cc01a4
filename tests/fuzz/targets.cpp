#include "tests/fuzz/targets.h"

#include <array>
#include <sstream>

#include "formats/content_seal.h"
#include "formats/control_mesh.h"
#include "formats/deformation_parts.h"
#include "formats/distance_field.h"
#include "formats/error.h"
#include "formats/face_anatomy.h"
#include "formats/geometry_image.h"
#include "formats/head_asset.h"
#include "formats/head_asset_document.h"
#include "formats/image.h"
#include "formats/motion.h"
#include "formats/muscle_file.h"
#include "formats/point_cloud.h"
#include "formats/scan_file.h"
#include "orchestrator/error.h"
#include "orchestrator/subject_list.h"
#include "store/checkpoint.h"
#include "store/error.h"
#include "store/key.h"
#include "store/pack.h"
#include "store/result.h"
#include "store/run_log.h"
#include "store/sealed_json.h"
#include "tests/store/memory_file_system.h"

namespace phiz::fuzz {
namespace {

void read_scan(const std::string& bytes, const char* extension) {
  ScanLimits limits;
  limits.max_points = 1'000'000;
  parse_scan(std::as_bytes(std::span(bytes)), extension, limits);
}
void read_ply(const std::string& bytes) {
  read_scan(bytes, ".ply");
}
void read_obj(const std::string& bytes) {
  read_scan(bytes, ".obj");
}
void read_stl(const std::string& bytes) {
  read_scan(bytes, ".stl");
}
void read_off(const std::string& bytes) {
  read_scan(bytes, ".off");
}
void read_text(const std::string& bytes) {
  read_scan(bytes, ".xyz");
}
void read_glb(const std::string& bytes) {
  read_scan(bytes, ".glb");
}
void read_drc(const std::string& bytes) {
  read_scan(bytes, ".drc");
}

template <auto kRead>
void read_stream(const std::string& bytes) {
  std::istringstream in(bytes);
  static_cast<void>(kRead(in));
}

/// OpenVDB's own reader, behind our seal: ours are sealed anew, so that the change gets past it.
std::string sealed_vdb(std::string bytes) {
  if (bytes.size() >= 57 && bytes.compare(21, 8, "7068697a") == 0) seal_vdb(bytes);
  return bytes;
}
void read_vdb(const std::string& bytes) {
  std::istringstream in(sealed_vdb(bytes));
  read_vdb_points(in);
}
void read_distance(const std::string& bytes) {
  std::istringstream in(sealed_vdb(bytes));
  read_vdb_distance_field(in);
}

/// An EXR file sealed anew, where it bears our seal.
std::string sealed_exr(std::string bytes) {
  const std::string entry("phizSeal\0string\0\x40\0\0\0", 20);
  constexpr std::size_t kSealLength = 64;
  const std::size_t at = bytes.find(entry);
  if (at != std::string::npos && at + entry.size() + kSealLength <= bytes.size()) {
    bytes.replace(at + entry.size(), kSealLength, digest_without(bytes, at + entry.size(), kSealLength));
  }
  return bytes;
}
void read_picture(const std::string& bytes) {
  std::istringstream in(sealed_exr(bytes));
  read_exr(in);
}
void read_geometry(const std::string& bytes) {
  std::istringstream in(sealed_exr(bytes));
  read_geometry_image(in);
}

void read_head(const std::string& bytes) {
  std::string text = bytes;
  try {
    const std::size_t at = head_asset_document::find_seal(text);
    if (at + head_asset_document::kSealLength <= text.size()) {
      text.replace(at, head_asset_document::kSealLength,
                   digest_without(text, at, head_asset_document::kSealLength));
    }
  } catch (const FormatError&) {
    // Then the reader says so too.
  }
  std::istringstream in(text);
  read_head_asset(in);
}

void read_template_json(const std::string& bytes) {
  std::istringstream obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"), json(bytes);
  read_control_mesh(obj, json);
}
void read_template_obj(const std::string& bytes) {
  std::istringstream obj(bytes), json("{}");
  read_control_mesh(obj, json);
}
void read_deformation_text(const std::string& bytes) {
  parse_deformation_json(bytes);
}

/// The text as an object under a seal that fits, where it is one; otherwise as it is.
std::string sealed(const std::string& bytes) {
  if (!bytes.ends_with("\n}")) return bytes;
  const std::string body = bytes.substr(0, bytes.size() - 2);
  return body + ",\n \"seal\": \"" + compute_digest(body).hex() + "\"\n}\n";
}
void read_result(const std::string& bytes) {
  parse_result(sealed(bytes), "it");
}
void read_subject(const std::string& bytes) {
  parse_subject(sealed(bytes), "it");
}
void read_key_text(const std::string& bytes) {
  if (const auto text = parse_key_text(bytes)) static_cast<void>(text->key());
}
void read_notes(const std::string& bytes) {
  static_cast<void>(parse_notes(bytes));
}
void read_checkpoint(const std::string& bytes) {
  static_cast<void>(is_whole_checkpoint(bytes));
}
void read_pack(const std::string& bytes) {
  test::MemoryFileSystem disk;
  unpack_subjects(Store::open_or_create(disk, "/store"), bytes);
}
void read_list(const std::string& bytes) {
  static_cast<void>(parse_subject_list(bytes, "it"));
}
void read_log(const std::string& bytes) {
  test::MemoryFileSystem disk;
  const Store store = Store::open_or_create(disk, "/store");
  disk.append("/store/logs/it.log", std::as_bytes(std::span(bytes)));
  static_cast<void>(read_run_log(store));
}

constexpr auto kTargets = std::to_array<Target>({
    {"ply", read_ply},
    {"obj", read_obj},
    {"stl", read_stl},
    {"off", read_off},
    {"text", read_text},
    {"glb", read_glb},
    {"drc", read_drc},
    {"vdb", read_stream<read_vdb_points>},
    {"distance", read_stream<read_vdb_distance_field>},
    {"vdb_behind_seal", read_vdb},
    {"distance_behind_seal", read_distance},
    {"exr", read_picture},
    {"png", read_stream<read_png>},
    {"head", read_head},
    {"geometry", read_geometry},
    {"template_json", read_template_json},
    {"template_obj", read_template_obj},
    {"motion", read_stream<read_motion>},
    {"deformation", read_deformation_text},
    {"muscle", read_stream<read_muscle_file>},
    {"anatomy", read_stream<read_face_anatomy>},
    {"rig", read_stream<read_rig_file>},
    {"result", read_result},
    {"subject", read_subject},
    {"key", read_key_text},
    {"notes", read_notes},
    {"checkpoint", read_checkpoint},
    {"pack", read_pack},
    {"list", read_list},
    {"log", read_log},
});

}  // namespace

std::span<const Target> list_targets() {
  return kTargets;
}

const Target* find_target(std::string_view name) {
  for (const Target& target : kTargets) {
    if (target.name == name) return &target;
  }
  return nullptr;
}

void run_target(const Target& target, const std::string& bytes) {
  try {
    target.read(bytes);
  } catch (const FormatError&) {
  } catch (const StoreError&) {
  } catch (const UsageError&) {
  }
}

}  // namespace phiz::fuzz
