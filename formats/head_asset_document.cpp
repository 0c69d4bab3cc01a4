#include "formats/head_asset_document.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "formats/error.h"

namespace phiz::head_asset_document {
namespace {

using Json = nlohmann::json;  // sorted keys: one text for one document

constexpr const char* kExtension = "PHIZ_displaced_subdivision";
constexpr const char* kDraco = "KHR_draco_mesh_compression";
constexpr int kSchema = 2;
constexpr const char* kCoder = "phiz-residual-1";
constexpr const char* kFirstCoder = "draco-sequential-int32";  // of schema 1
constexpr const char* kScheme = "modified-butterfly";
constexpr std::string_view kSealKey = "\"seal\":\"";
constexpr int kFloat = 5126, kUnsignedInt = 5125, kTriangles = 4;

// ---- writing

/// Appends a buffer view and returns its index.
std::size_t add_view(Json& views, const Stream& stream) {
  views.push_back({{"buffer", 0}, {"byteOffset", stream.offset}, {"byteLength", stream.length}});
  return views.size() - 1;
}

Json rows_of(const Eigen::Matrix4d& matrix) {
  Json rows = Json::array();
  for (int row = 0; row < 4; ++row) {
    Json numbers = Json::array();
    for (int column = 0; column < 4; ++column) numbers.push_back(matrix(row, column));
    rows.push_back(std::move(numbers));
  }
  return rows;
}

Json extension_of(const Document& document, Json& views, std::size_t mesh_view) {
  Json levels = Json::array();
  const std::size_t texture_view = add_view(views, document.texture);
  for (const Level& level : document.levels) {
    levels.push_back({{"vertices", level.vertex_count},
                      {"step_mm", level.step_mm},
                      {"displacements", add_view(views, level.displacements)},
                      {"crc32", level.displacements.sum}});
  }
  for (std::size_t k = 0; document.has_confidences && k < levels.size(); ++k)
    levels[k]["confidences"] = add_view(views, document.levels[k].confidences);
  Json extension = {
      {"schema", kSchema},
      {"scheme", kScheme},
      {"coder", kCoder},
      {"unit", "mm"},
      {"template", document.template_digest},
      {"control",
       {{"bufferView", mesh_view},
        {"crc32", document.mesh.sum},
        {"vertices", document.vertex_count},
        {"triangles", document.triangle_count},
        {"position_step_mm", document.position_step_mm}}},
      {"texture",
       {{"bufferView", texture_view}, {"crc32", document.texture.sum}, {"steps", document.texture_steps}}},
      {"shown_level", document.shown_level},
      {"levels", std::move(levels)},
      {"scan_from_head", rows_of(document.scan_from_head)},
      {"seal", std::string(kSealLength, '0')}};
  if (document.has_confidences) extension["confidence_step"] = document.confidence_step;
  if (document.tolerance_mm > 0) extension["tolerance_mm"] = document.tolerance_mm;
  if (!document.provenance.empty()) extension["provenance"] = document.provenance;
  return extension;
}

Json accessors_of(const Document& document) {
  const auto list = [](const Eigen::Vector3f& v) { return Json::array({v.x(), v.y(), v.z()}); };
  const Json position = {{"componentType", kFloat},
                         {"type", "VEC3"},
                         {"count", document.shown_vertex_count},
                         {"min", list(document.low)},
                         {"max", list(document.high)}};
  const Json corners = {
      {"componentType", kUnsignedInt}, {"type", "SCALAR"}, {"count", 3 * document.shown_triangle_count}};
  return Json::array({position, corners});
}

Json mesh_of(std::size_t draco_view) {
  Json primitive, mesh;
  primitive["attributes"] = {{"POSITION", 0}};
  primitive["indices"] = 1;
  primitive["mode"] = kTriangles;
  primitive["material"] = 0;
  primitive["extensions"][kDraco] = {{"bufferView", draco_view}, {"attributes", {{"POSITION", 0}}}};
  mesh["name"] = "head";
  mesh["primitives"] = Json::array({std::move(primitive)});
  return mesh;
}

// ---- reading

[[noreturn]] void fail(const std::string& what, const std::string& path) {
  throw FormatError(what + " (" + path + ")");
}

const Json& member(const Json& object, const std::string& key, const std::string& path) {
  if (!object.is_object() || !object.contains(key)) fail("missing key '" + key + "'", path);
  return object[key];
}

std::size_t parse_count(const Json& object, const std::string& key, const std::string& path) {
  const Json& value = member(object, key, path);
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > 0xffffffffu)
    fail("'" + key + "' is no count", path);
  return value.get<std::size_t>();
}

double parse_double(const Json& value, const std::string& path) {
  if (!value.is_number()) fail("is not a number", path);
  return value.get<double>();
}

void check_text(const Json& object, const char* key, const char* expected, const std::string& path) {
  if (member(object, key, path) != expected)
    fail(std::string("'") + key + "' is not '" + expected + "'", path);
}

const Json& element(const Json& object, const std::string& key, std::size_t idx, const std::string& path) {
  const Json& list = member(object, key, path);
  if (!list.is_array() || idx >= list.size())
    fail("'" + key + "' has no element " + std::to_string(idx), path);
  return list[idx];
}

Stream parse_stream(const Json& root, std::size_t view_idx, std::size_t bin_length) {
  const Json& view = element(root, "bufferViews", view_idx, "root");
  const std::string path = "bufferViews[" + std::to_string(view_idx) + "]";
  const Stream stream{parse_count(view, "byteOffset", path), parse_count(view, "byteLength", path)};
  if (stream.offset > bin_length || stream.length > bin_length - stream.offset)
    fail("lies beyond the file", path);
  return stream;
}

Eigen::Matrix4d parse_matrix(const Json& extension) {
  Eigen::Matrix4d matrix;
  for (std::size_t row = 0; row < 4; ++row) {
    const Json& numbers = element(extension, "scan_from_head", row, kExtension);
    const std::string path = "scan_from_head[" + std::to_string(row) + "]";
    if (!numbers.is_array() || numbers.size() != 4) fail("does not have four numbers", path);
    for (std::size_t column = 0; column < 4; ++column) {
      matrix(static_cast<int>(row), static_cast<int>(column)) = parse_double(numbers[column], path);
    }
  }
  return matrix;
}

/// Schema 1: the primitive is the control mesh with its (u,v).
void parse_first_mesh(const Json& root, std::size_t bin_length, Document& document) {
  const Json& primitive = element(element(root, "meshes", 0, "root"), "primitives", 0, "meshes[0]");
  const std::string path = "meshes[0].primitives[0]";
  const Json& draco = member(member(primitive, "extensions", path), kDraco, path);
  document.mesh = parse_stream(root, parse_count(draco, "bufferView", path), bin_length);
  document.vertex_count = parse_count(element(root, "accessors", 0, "root"), "count", "accessors[0]");
  const std::size_t corner_count =
      parse_count(element(root, "accessors", 2, "root"), "count", "accessors[2]");
  if (corner_count % 3 != 0) fail("'count' is no multiple of three", "accessors[2]");
  document.triangle_count = corner_count / 3;
}

void parse_mesh(const Json& root, const Json& extension, std::size_t bin_length, Document& document) {
  const Json& control = member(extension, "control", kExtension);
  document.mesh = parse_stream(root, parse_count(control, "bufferView", "control"), bin_length);
  document.mesh.sum = static_cast<std::uint32_t>(parse_count(control, "crc32", "control"));
  document.vertex_count = parse_count(control, "vertices", "control");
  document.triangle_count = parse_count(control, "triangles", "control");
  document.position_step_mm =
      parse_double(member(control, "position_step_mm", "control"), "position_step_mm");
  const Json& texture = member(extension, "texture", kExtension);
  document.texture = parse_stream(root, parse_count(texture, "bufferView", "texture"), bin_length);
  document.texture.sum = static_cast<std::uint32_t>(parse_count(texture, "crc32", "texture"));
  document.texture_steps =
      static_cast<int>(std::min<std::size_t>(parse_count(texture, "steps", "texture"), 65536));
}

void parse_levels(const Json& root, const Json& extension, std::size_t bin_length, Document& document) {
  const Json& levels = member(extension, "levels", kExtension);
  if (!levels.is_array()) fail("'levels' is no list", kExtension);
  document.has_confidences = !levels.empty() && levels[0].is_object() && levels[0].contains("confidences");
  const bool is_first = document.schema == 1;
  for (std::size_t k = 0; k < levels.size(); ++k) {
    const std::string path = "levels[" + std::to_string(k) + "]";
    Level level{parse_count(levels[k], "vertices", path), 0, {}, {}};
    level.step_mm = is_first ? parse_double(member(extension, "displacement_step_mm", kExtension), "step")
                             : parse_double(member(levels[k], "step_mm", path), path);
    level.displacements = parse_stream(root, parse_count(levels[k], "displacements", path), bin_length);
    if (!is_first)
      level.displacements.sum = static_cast<std::uint32_t>(parse_count(levels[k], "crc32", path));
    if (document.has_confidences) {
      level.confidences = parse_stream(root, parse_count(levels[k], "confidences", path), bin_length);
    }
    document.levels.push_back(level);
  }
}

/// What only schema 2 has.
void parse_extras(const Json& extension, Document& document) {
  if (document.has_confidences) {
    document.confidence_step =
        static_cast<int>(std::min<std::size_t>(parse_count(extension, "confidence_step", kExtension), 256));
  }
  if (extension.contains("tolerance_mm"))
    document.tolerance_mm = parse_double(extension["tolerance_mm"], "tolerance_mm");
  document.shown_level =
      static_cast<int>(std::min<std::size_t>(parse_count(extension, "shown_level", kExtension), 99));
  if (!extension.contains("provenance")) return;
  if (!extension["provenance"].is_object()) fail("'provenance' is no object", kExtension);
  for (const auto& [name, digest] : extension["provenance"].items()) {
    if (!digest.is_string()) fail("is no text", "provenance." + name);
    document.provenance[name] = digest.get<std::string>();
  }
}

Json parse_text(std::string_view text) {
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    throw FormatError("glb has broken JSON (byte " + std::to_string(error.byte + 20) + ")");
  } catch (const Json::exception&) {
    throw FormatError("glb has JSON with numbers out of range");
  }
}

}  // namespace

std::string format(const Document& document) {
  Json root, scene, buffer, views = Json::array();
  const Json node = {{"mesh", 0}, {"name", "head"}, {"scale", {0.001, 0.001, 0.001}}};
  const Json material = {{"name", "skin"},
                         {"doubleSided", true},
                         {"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 0.7}}}};
  scene["nodes"] = Json::array({0});
  buffer["byteLength"] = document.bin_length;
  root["asset"] = {{"generator", "phiz"}, {"version", "2.0"}};
  root["extensionsUsed"] = Json::array({kDraco, kExtension});
  root["extensionsRequired"] = Json::array({kDraco});
  root["scene"] = 0;
  root["scenes"] = Json::array({scene});
  root["nodes"] = Json::array({node});
  root["materials"] = Json::array({material});
  root["accessors"] = accessors_of(document);
  const std::size_t mesh_view = add_view(views, document.mesh);
  root["extensions"][kExtension] = extension_of(document, views, mesh_view);
  const bool is_control = document.shown_level == 0;
  root["meshes"] = Json::array({mesh_of(is_control ? mesh_view : add_view(views, document.shown))});
  root["bufferViews"] = std::move(views);
  root["buffers"] = Json::array({buffer});
  return root.dump();
}

Document parse(std::string_view json, std::size_t bin_length) {
  const Json root = parse_text(json);
  const Json& extension = member(member(root, "extensions", "root"), kExtension, "extensions");
  Document document;
  const Json& schema = member(extension, "schema", kExtension);
  if (schema != 1 && schema != kSchema) {
    throw FormatError("'schema' is neither 1 nor 2 (" + std::string(kExtension) + ")",
                      "it was written by a newer phiz");
  }
  document.schema = schema.get<int>();
  check_text(extension, "scheme", kScheme, kExtension);
  check_text(extension, "coder", document.schema == 1 ? kFirstCoder : kCoder, kExtension);
  check_text(extension, "unit", "mm", kExtension);
  const Json& digest = member(extension, "template", kExtension);
  if (!digest.is_string()) fail("'template' is no text", kExtension);
  document.bin_length = bin_length;
  document.template_digest = digest.get<std::string>();
  document.scan_from_head = parse_matrix(extension);
  if (document.schema == 1) {
    document.position_step_mm = parse_double(member(extension, "position_step_mm", kExtension), "step");
    parse_first_mesh(root, bin_length, document);
    parse_levels(root, extension, bin_length, document);
  } else {
    parse_mesh(root, extension, bin_length, document);
    parse_levels(root, extension, bin_length, document);
    parse_extras(extension, document);
  }
  return document;
}

void check_name(const std::string& name, const char* what) {
  const bool good = name.size() <= 128 && std::all_of(name.begin(), name.end(), [](char c) {
                      return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                             c == '-' || c == '_' || c == ':' || c == '.';
                    });
  if (!good) throw FormatError(std::string(what) + " has other characters than letters, digits and -_:.");
}

std::size_t find_seal(std::string_view bytes) {
  const std::size_t key = bytes.find(kSealKey);
  const std::size_t at = key + kSealKey.size();
  if (key == std::string_view::npos || bytes.size() - at <= kSealLength || bytes[at + kSealLength] != '"') {
    throw FormatError("is no head asset: it bears no seal");
  }
  return at;
}

}  // namespace phiz::head_asset_document
