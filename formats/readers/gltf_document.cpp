#include "formats/readers/gltf_document.h"

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "formats/readers/byte_order.h"
#include "formats/readers/fail.h"

namespace phiz::readers {
namespace {

using nlohmann::json;

constexpr std::uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;

[[noreturn]] void fail(const std::string& fault, const std::string& hint = kHintDamaged) {
  throw FormatError(fault + " (glTF header)", hint);
}

/// The member `key` if it is there.
const json* find(const json& object, const char* key) {
  if (!object.is_object()) fail("an object is expected around '" + std::string(key) + "'");
  const auto member = object.find(key);
  return member == object.end() ? nullptr : &*member;
}

const json& array_of(const json& object, const char* key) {
  static const json kNone = json::array();
  const json* member = find(object, key);
  if (member && !member->is_array()) fail(quoted(key) + " is not an array");
  return member ? *member : kNone;
}

double number_of(const json& value, const char* key) {
  if (!value.is_number()) fail(quoted(key) + " is not a number");
  return value.get<double>();
}

/// A whole number below 2^53.
std::uint64_t whole_of(const json& value, const char* key) {
  const double number = number_of(value, key);
  if (!(number >= 0.0 && number < 9007199254740992.0) || number != std::floor(number))
    fail(quoted(key) + " is not a whole number");
  return static_cast<std::uint64_t>(number);
}

std::uint64_t whole(const json& object, const char* key, std::uint64_t otherwise) {
  const json* member = find(object, key);
  return member ? whole_of(*member, key) : otherwise;
}

int index_of(const json& value, const char* key, std::size_t count) {
  const std::uint64_t idx = whole_of(value, key);
  if (idx >= count)
    fail(quoted(key) + " " + std::to_string(idx) + " is not there, there are " + std::to_string(count));
  return static_cast<int>(idx);
}

/// -1 if the key is not there.
int index(const json& object, const char* key, std::size_t count) {
  const json* member = find(object, key);
  return member ? index_of(*member, key, count) : -1;
}

bool flag(const json& object, const char* key) {
  const json* member = find(object, key);
  return member && member->is_boolean() && member->get<bool>();
}

template <int kSize>
bool read_vector(const json& object, const char* key, Eigen::Matrix<double, kSize, 1>& vector) {
  const json& values = array_of(object, key);
  if (values.empty()) return false;
  if (values.size() != kSize) fail(quoted(key) + " has not " + std::to_string(kSize) + " numbers");
  for (int i = 0; i < kSize; ++i) vector[i] = number_of(values[static_cast<std::size_t>(i)], key);
  return true;
}

GltfView parse_view(const json& value, const json& buffers) {
  GltfView view;
  const int buffer_idx = index(value, "buffer", buffers.size());
  view.byte_offset = whole(value, "byteOffset", 0);
  view.byte_length = whole(value, "byteLength", 0);
  view.byte_stride = whole(value, "byteStride", 0);
  const json* extensions = find(value, "extensions");
  if (extensions && find(*extensions, "EXT_meshopt_compression")) view.unusable = "is compressed by meshopt";
  if (buffer_idx != 0 || find(buffers[0], "uri"))
    view.unusable = "is outside the file (external or data: buffer)";
  return view;
}

GltfAccessor parse_accessor(const json& value, std::size_t views) {
  GltfAccessor accessor;
  accessor.view_idx = index(value, "bufferView", views);
  accessor.byte_offset = whole(value, "byteOffset", 0);
  accessor.count = whole(value, "count", 0);
  accessor.component_type = static_cast<int>(std::min<std::uint64_t>(whole(value, "componentType", 0), 9999));
  accessor.is_normalized = flag(value, "normalized");
  accessor.is_sparse = find(value, "sparse");
  const json* type = find(value, "type");
  const std::string name = type && type->is_string() ? type->get<std::string>() : "";
  accessor.components = name == "SCALAR" ? 1
                        : name == "VEC2" ? 2
                        : name == "VEC3" ? 3
                        : name == "VEC4" ? 4
                                         : 0;
  return accessor;
}

GltfPrimitive parse_primitive(const json& value, const GltfDocument& document) {
  GltfPrimitive primitive;
  primitive.mode = static_cast<int>(std::min<std::uint64_t>(whole(value, "mode", 4), 9999));
  primitive.indices_idx = index(value, "indices", document.accessors.size());
  if (const json* attributes = find(value, "attributes")) {
    primitive.position_idx = index(*attributes, "POSITION", document.accessors.size());
    primitive.normal_idx = index(*attributes, "NORMAL", document.accessors.size());
    primitive.colour_idx = index(*attributes, "COLOR_0", document.accessors.size());
  }
  const json* extensions = find(value, "extensions");
  const json* draco = extensions ? find(*extensions, "KHR_draco_mesh_compression") : nullptr;
  if (!draco) return primitive;
  constexpr std::size_t kMostIds = 65536;
  GltfDraco stream;
  stream.view_idx = index(*draco, "bufferView", document.views.size());
  const json* ids = find(*draco, "attributes");
  if (stream.view_idx < 0 || !ids) fail("a Draco primitive has no bufferView or attributes");
  stream.ids.position = index(*ids, "POSITION", kMostIds);
  stream.ids.normal = index(*ids, "NORMAL", kMostIds);
  stream.ids.colour = index(*ids, "COLOR_0", kMostIds);
  primitive.draco = stream;
  return primitive;
}

GltfNode parse_node(const json& value, std::size_t nodes, std::size_t meshes) {
  GltfNode node;
  node.mesh_idx = index(value, "mesh", meshes);
  for (const json& child : array_of(value, "children"))
    node.children.push_back(index_of(child, "children", nodes));
  Eigen::Matrix<double, 16, 1> matrix;
  if (read_vector<16>(value, "matrix", matrix)) {
    node.parent_from_node = Eigen::Map<const Eigen::Matrix4d>(matrix.data());  // both are stored by columns
    return node;
  }
  Eigen::Vector3d translation = Eigen::Vector3d::Zero(), scale = Eigen::Vector3d::Ones();
  Eigen::Vector4d rotation(0, 0, 0, 1);
  read_vector<3>(value, "translation", translation);
  read_vector<4>(value, "rotation", rotation);
  read_vector<3>(value, "scale", scale);
  const Eigen::Quaterniond turn(rotation[3], rotation[0], rotation[1], rotation[2]);
  node.parent_from_node.topLeftCorner<3, 3>() = turn.normalized().toRotationMatrix() * scale.asDiagonal();
  node.parent_from_node.topRightCorner<3, 1>() = translation;
  return node;
}

/// The nodes of the default scene, or all that are nobody's child.
std::vector<int> find_roots(const json& root, const std::vector<GltfNode>& nodes) {
  std::vector<int> roots;
  const json& scenes = array_of(root, "scenes");
  if (!scenes.empty()) {
    const int scene_idx = std::max(index(root, "scene", scenes.size()), 0);
    for (const json& node : array_of(scenes[static_cast<std::size_t>(scene_idx)], "nodes"))
      roots.push_back(index_of(node, "nodes", nodes.size()));
    return roots;
  }
  std::vector<bool> is_child(nodes.size(), false);
  for (const GltfNode& node : nodes)
    for (const int child : node.children) is_child[static_cast<std::size_t>(child)] = true;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (!is_child[i]) roots.push_back(static_cast<int>(i));
  return roots;
}

void take_json(const json& root, GltfDocument& document) {
  const json& buffers = array_of(root, "buffers");
  for (const json& value : array_of(root, "bufferViews"))
    document.views.push_back(parse_view(value, buffers));
  for (const json& value : array_of(root, "accessors"))
    document.accessors.push_back(parse_accessor(value, document.views.size()));
  for (const json& value : array_of(root, "meshes")) {
    document.meshes.emplace_back();
    for (const json& primitive : array_of(value, "primitives"))
      document.meshes.back().push_back(parse_primitive(primitive, document));
  }
  const json& nodes = array_of(root, "nodes");
  for (const json& value : nodes)
    document.nodes.push_back(parse_node(value, nodes.size(), document.meshes.size()));
  document.roots = find_roots(root, document.nodes);
}

json parse_json(std::span<const std::byte> chunk, std::size_t file_byte) {
  const std::string_view text(reinterpret_cast<const char*>(chunk.data()), chunk.size());
  try {
    return json::parse(text);
  } catch (const json::parse_error& error) {
    fail_at_byte("the glTF header is not JSON", file_byte + error.byte, kHintDamaged);
  } catch (const json::exception&) {
    fail_at_byte("the glTF header has numbers out of range", file_byte, kHintDamaged);
  }
}

std::size_t component_bytes(int component_type) {
  switch (component_type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      fail("componentType " + std::to_string(component_type) + " is not known");
  }
}

}  // namespace

GltfDocument parse_glb(std::span<const std::byte> bytes) {
  constexpr std::size_t kHead = 12, kChunkHead = 8;
  if (bytes.size() < kHead + kChunkHead) fail_at_byte("the glTF file is cut", bytes.size(), kHintCut);
  const std::uint32_t version = load<std::uint32_t>(bytes.data() + 4);
  if (version != 2)
    fail_at_byte("is glTF version " + std::to_string(version), 4, "export as glTF 2.0 (.glb)");
  const std::uint32_t length = load<std::uint32_t>(bytes.data() + 8);
  if (length > bytes.size() || length < kHead)
    fail_at_byte("the glTF file says it has " + std::to_string(length) + " bytes, it has " +
                     std::to_string(bytes.size()),
                 8, kHintCut);
  GltfDocument document;
  json root;
  bool has_json = false;
  for (std::size_t at = kHead; at + kChunkHead <= length;) {
    const std::uint32_t size = load<std::uint32_t>(bytes.data() + at),
                        kind = load<std::uint32_t>(bytes.data() + at + 4);
    at += kChunkHead;
    if (size > length - at) fail_at_byte("a chunk of the glTF file is cut", at, kHintCut);
    if (kind == kJsonChunk && !has_json) {
      root = parse_json(bytes.subspan(at, size), at);
      has_json = true;
    } else if (kind == kBinaryChunk && document.binary.empty()) {
      document.binary = bytes.subspan(at, size);
      document.binary_byte = at;
    }
    at += size;
  }
  if (!has_json) fail_at_byte("the glTF file has no JSON chunk", kHead, kHintDamaged);
  take_json(root, document);
  return document;
}

std::span<const std::byte> bytes_of_view(const GltfDocument& document, int view_idx) {
  const GltfView& view = document.views[static_cast<std::size_t>(view_idx)];
  if (!view.unusable.empty())
    fail("bufferView " + std::to_string(view_idx) + " " + view.unusable,
         "export as one .glb with embedded plain or Draco data");
  if (view.byte_offset > document.binary.size() ||
      view.byte_length > document.binary.size() - view.byte_offset)
    fail_at_byte("bufferView " + std::to_string(view_idx) + " reaches beyond the binary chunk",
                 document.binary_byte + document.binary.size(), kHintCut);
  return document.binary.subspan(view.byte_offset, view.byte_length);
}

GltfNumbers::GltfNumbers(const GltfDocument& document, int accessor_idx, int least_components)
    : accessor_(&document.accessors[static_cast<std::size_t>(accessor_idx)]) {
  const std::string name = "accessor " + std::to_string(accessor_idx);
  if (accessor_->is_sparse) fail(name + " is sparse", "export without sparse accessors");
  if (accessor_->view_idx < 0) fail(name + " has no data");
  if (accessor_->components < least_components) fail(name + " has too few components");
  component_bytes_ = component_bytes(accessor_->component_type);
  const std::size_t row_bytes = component_bytes_ * static_cast<std::size_t>(accessor_->components);
  const std::span<const std::byte> view = bytes_of_view(document, accessor_->view_idx);
  const std::uint64_t view_stride = document.views[static_cast<std::size_t>(accessor_->view_idx)].byte_stride;
  stride_ = view_stride > 0 ? view_stride : row_bytes;
  if (accessor_->count == 0) return;
  const bool fits = accessor_->byte_offset <= view.size() &&
                    row_bytes <= view.size() - accessor_->byte_offset &&
                    accessor_->count - 1 <= (view.size() - accessor_->byte_offset - row_bytes) / stride_;
  if (!fits) fail(name + " reaches beyond its bufferView", kHintCut);
  first_ = view.data() + accessor_->byte_offset;
}

double GltfNumbers::at(std::uint64_t row, int component) const {
  const std::byte* at = first_ + row * stride_ + static_cast<std::size_t>(component) * component_bytes_;
  const bool scaled = accessor_->is_normalized;
  switch (accessor_->component_type) {
    case 5120:
      return scaled ? std::max(load<std::int8_t>(at) / 127.0, -1.0) : load<std::int8_t>(at);
    case 5121:
      return scaled ? load<std::uint8_t>(at) / 255.0 : load<std::uint8_t>(at);
    case 5122:
      return scaled ? std::max(load<std::int16_t>(at) / 32767.0, -1.0) : load<std::int16_t>(at);
    case 5123:
      return scaled ? load<std::uint16_t>(at) / 65535.0 : load<std::uint16_t>(at);
    case 5125:
      return load<std::uint32_t>(at);
    default:
      return static_cast<double>(load<float>(at));
  }
}

}  // namespace phiz::readers
