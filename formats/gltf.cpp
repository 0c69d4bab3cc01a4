#include "formats/gltf.h"

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "formats/draco_streams.h"
#include "formats/error.h"
#include "formats/glb_chunks.h"
#include "formats/text.h"

namespace phiz {
namespace {

using Json = nlohmann::json;  // sorted keys: one text for one document

constexpr int kFloat = 5126, kUnsignedInt = 5125, kUnsignedShort = 5123;
constexpr int kVertices = 34962, kIndices = 34963;
constexpr int kPoints = 0, kTriangles = 4;

/// A document of one mesh that grows an attribute at a time.
class MeshDocument {
 public:
  /// Appends rows of `Row` as a buffer view and an accessor of all their values; returns the accessor's
  /// index.
  template <typename Row>
  std::size_t append(const std::vector<Row>& rows, Json accessor, int target) {
    const std::size_t length = rows.size() * sizeof(Row);
    views_.push_back(
        {{"buffer", 0}, {"byteOffset", bin_.size()}, {"byteLength", length}, {"target", target}});
    accessor["bufferView"] = views_.size() - 1;
    accessors_.push_back(std::move(accessor));
    bin_.resize(bin_.size() + length);  // every row is a multiple of four bytes: no padding between views
    std::memcpy(bin_.data() + bin_.size() - length, rows.data(), length);
    return accessors_.size() - 1;
  }

  std::string finish(Json primitive) && {
    const Json material = {{"name", "skin"},
                           {"doubleSided", true},
                           {"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 0.7}}}};
    primitive["material"] = 0;
    const Json node = {{"mesh", 0}, {"name", "head"}, {"scale", {0.001, 0.001, 0.001}}};
    Json mesh, scene, buffer, document;
    mesh["name"] = "head";
    mesh["primitives"] = Json::array({std::move(primitive)});
    scene["nodes"] = Json::array({0});
    buffer["byteLength"] = bin_.size();
    document["asset"] = {{"generator", "phiz"}, {"version", "2.0"}};
    document["scene"] = 0;
    document["scenes"] = Json::array({std::move(scene)});
    document["nodes"] = Json::array({node});
    document["meshes"] = Json::array({std::move(mesh)});
    document["materials"] = Json::array({material});
    document["accessors"] = std::move(accessors_);
    document["bufferViews"] = std::move(views_);
    document["buffers"] = Json::array({std::move(buffer)});
    return join_glb(document.dump(), bin_);
  }

 private:
  Json views_ = Json::array(), accessors_ = Json::array();
  std::string bin_;
};

Json accessor_of(int component, const char* type, std::size_t count) {
  return {{"componentType", component}, {"type", type}, {"count", count}};
}

Json position_accessor(const std::vector<Eigen::Vector3f>& positions) {
  Eigen::Vector3f low = positions.front(), high = low;
  for (const Eigen::Vector3f& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  Json accessor = accessor_of(kFloat, "VEC3", positions.size());
  accessor["min"] = {low.x(), low.y(), low.z()};
  accessor["max"] = {high.x(), high.y(), high.z()};
  return accessor;
}

std::vector<Eigen::Vector3f> unit_normals(const std::vector<Eigen::Vector3f>& normals) {
  std::vector<Eigen::Vector3f> unit;
  unit.reserve(normals.size());
  for (const Eigen::Vector3f& normal : normals) {
    const Eigen::Vector3d direction = normal.cast<double>();
    const double length = direction.norm();
    unit.emplace_back(Eigen::Vector3f::UnitY());
    if (length > 0.0) unit.back() = (direction / length).cast<float>();
  }
  return unit;
}

std::vector<Eigen::Vector2f> texture_coordinates(const std::vector<Eigen::Vector2f>& uv) {
  std::vector<Eigen::Vector2f> texture;
  texture.reserve(uv.size());
  for (const Eigen::Vector2f& row : uv) texture.emplace_back(row.x(), 1.0f - row.y());
  return texture;
}

/// glTF's vertex colours are linear (IEC 61966-2-1 gives the curve).
std::uint16_t linear_of(std::uint8_t srgb) {
  const double share = srgb / 255.0;
  const double linear = share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
  return static_cast<std::uint16_t>(linear * 65535.0 + 0.5);
}

std::vector<std::array<std::uint16_t, 4>> linear_colours(
    const std::vector<std::array<std::uint8_t, 3>>& colours) {
  std::array<std::uint16_t, 256> linear;
  for (std::size_t i = 0; i < linear.size(); ++i) linear[i] = linear_of(static_cast<std::uint8_t>(i));
  std::vector<std::array<std::uint16_t, 4>> rows;
  rows.reserve(colours.size());
  for (const auto& [r, g, b] : colours) rows.push_back({linear[r], linear[g], linear[b], 65535});
  return rows;
}

}  // namespace

void write_glb(const TriangleMesh& mesh, std::ostream& out) {
  check_mesh(mesh);
  const std::size_t count = mesh.vertex_count();
  if (count == 0) throw FormatError("a glb needs vertices");
  MeshDocument document;
  Json attributes;
  attributes["POSITION"] = document.append(mesh.positions, position_accessor(mesh.positions), kVertices);
  if (!mesh.normals.empty()) {
    attributes["NORMAL"] =
        document.append(unit_normals(mesh.normals), accessor_of(kFloat, "VEC3", count), kVertices);
  }
  if (!mesh.uv.empty()) {
    attributes["TEXCOORD_0"] =
        document.append(texture_coordinates(mesh.uv), accessor_of(kFloat, "VEC2", count), kVertices);
  }
  if (!mesh.colours.empty()) {
    Json accessor = accessor_of(kUnsignedShort, "VEC4", count);
    accessor["normalized"] = true;
    attributes["COLOR_0"] = document.append(linear_colours(mesh.colours), std::move(accessor), kVertices);
  }
  Json primitive = {{"attributes", std::move(attributes)},
                    {"mode", mesh.triangles.empty() ? kPoints : kTriangles}};
  if (!mesh.triangles.empty()) {
    const Json accessor = accessor_of(kUnsignedInt, "SCALAR", 3 * mesh.triangle_count());
    primitive["indices"] = document.append(mesh.triangles, accessor, kIndices);
  }
  write_all(out, std::move(document).finish(std::move(primitive)));
}

void write_drc(const TriangleMesh& mesh, std::ostream& out) {
  write_all(out, encode_draco(mesh));
}

}  // namespace phiz
