#include "formats/animated_mesh.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/error.h"
#include "formats/glb_chunks.h"
#include "formats/gltf.h"
#include "formats/text.h"

namespace phiz {
namespace {

using Json = nlohmann::json;

constexpr int kFloat = 5126, kUnsignedInt = 5125, kUnsignedShort = 5123;

void check(const AnimatedMesh& animated) {
  check_mesh(animated.mesh);
  if (animated.mesh.positions.empty() || animated.mesh.triangles.empty())
    throw FormatError("an animated mesh needs triangles");
  for (const MorphTarget& target : animated.targets) {
    const std::string what = "morph target '" + target.name + "'";
    if (target.vertices.size() != target.offsets.size()) throw FormatError(what + ": an offset a vertex");
    int last = -1;
    for (std::size_t i = 0; i < target.vertices.size(); ++i) {
      const int vertex = target.vertices[i];
      if (vertex <= last || vertex >= static_cast<int>(animated.mesh.positions.size()))
        throw FormatError(what + ": vertices do not ascend within the mesh");
      if (!target.offsets[i].allFinite()) throw FormatError(what + ": an offset is not finite");
      last = vertex;
    }
  }
  if (animated.weights.size() != animated.times_s.size() * animated.targets.size())
    throw FormatError("an animation without a weight for each target and frame");
  for (std::size_t i = 0; i < animated.times_s.size(); ++i) {
    if (!std::isfinite(animated.times_s[i]) || (i > 0 && !(animated.times_s[i] > animated.times_s[i - 1])))
      throw FormatError("times of an animation do not ascend");
  }
  for (const float weight : animated.weights) {
    if (!std::isfinite(weight)) throw FormatError("a weight is not finite");
  }
}

/// A document that grows by buffer views and accessors.
struct Document {
  Json root;
  std::string bin;

  template <typename Row>
  std::size_t add_view(const std::vector<Row>& rows) {
    const std::size_t length = rows.size() * sizeof(Row);
    bin.resize((bin.size() + 3) / 4 * 4);
    root["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", length}});
    bin.resize(bin.size() + length);
    std::memcpy(bin.data() + bin.size() - length, rows.data(), length);
    return root["bufferViews"].size() - 1;
  }

  std::size_t add_accessor(Json accessor) {
    root["accessors"].push_back(std::move(accessor));
    return root["accessors"].size() - 1;
  }
};

Json to_json(const Eigen::Vector3f& v) {
  return {v.x(), v.y(), v.z()};
}

/// Zeros but for the target's vertices; an accessor without any is plain zeros.
std::size_t add_target(Document& document, const MorphTarget& target, std::size_t vertex_count) {
  Eigen::Vector3f low = Eigen::Vector3f::Zero(), high = low;
  if (target.vertices.size() == vertex_count) low = high = target.offsets[0];
  for (const Eigen::Vector3f& offset : target.offsets) {
    low = low.cwiseMin(offset);
    high = high.cwiseMax(offset);
  }
  Json accessor = {{"componentType", kFloat},
                   {"type", "VEC3"},
                   {"count", vertex_count},
                   {"min", to_json(low)},
                   {"max", to_json(high)}};
  if (!target.vertices.empty()) {
    const bool is_short = vertex_count <= 65536;
    const std::size_t indices =
        is_short
            ? document.add_view(std::vector<std::uint16_t>(target.vertices.begin(), target.vertices.end()))
            : document.add_view(target.vertices);
    const int type = is_short ? kUnsignedShort : kUnsignedInt;
    accessor["sparse"] = {{"count", target.vertices.size()},
                          {"indices", {{"bufferView", indices}, {"componentType", type}}},
                          {"values", {{"bufferView", document.add_view(target.offsets)}}}};
  }
  return document.add_accessor(std::move(accessor));
}

void add_animation(Document& document, const AnimatedMesh& animated) {
  const std::size_t times = document.add_accessor({{"componentType", kFloat},
                                                   {"type", "SCALAR"},
                                                   {"count", animated.times_s.size()},
                                                   {"min", {animated.times_s.front()}},
                                                   {"max", {animated.times_s.back()}},
                                                   {"bufferView", document.add_view(animated.times_s)}});
  const std::size_t weights = document.add_accessor({{"componentType", kFloat},
                                                     {"type", "SCALAR"},
                                                     {"count", animated.weights.size()},
                                                     {"bufferView", document.add_view(animated.weights)}});
  const Json sampler = {{"input", times}, {"output", weights}, {"interpolation", "LINEAR"}};
  const Json channel = {{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}};
  Json animation = {{"name", "motion"}};
  animation["samplers"] = Json::array({sampler});
  animation["channels"] = Json::array({channel});
  document.root["animations"] = Json::array({animation});
}

}  // namespace

void write_animated_glb(const AnimatedMesh& animated, std::ostream& out) {
  check(animated);
  std::ostringstream plain;
  write_glb(animated.mesh, plain);
  const std::string bytes = std::move(plain).str();
  const GlbChunks chunks = split_glb(bytes);
  Document document{Json::parse(chunks.json), std::string(chunks.bin)};
  Json& mesh = document.root["meshes"][0];
  if (!animated.targets.empty()) {
    Json targets = Json::array(), names = Json::array(), rest = Json::array();
    for (const MorphTarget& target : animated.targets) {
      targets.push_back({{"POSITION", add_target(document, target, animated.mesh.positions.size())}});
      names.push_back(target.name);
      rest.push_back(0.0);
    }
    mesh["primitives"][0]["targets"] = std::move(targets);
    mesh["extras"]["targetNames"] = std::move(names);
    mesh["weights"] = std::move(rest);
    if (!animated.times_s.empty()) add_animation(document, animated);
  }
  document.root["buffers"][0]["byteLength"] = document.bin.size();
  write_all(out, join_glb(document.root.dump(), document.bin));
}

}  // namespace phiz
