#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/error.h"
#include "formats/glb_chunks.h"
#include "formats/gltf.h"
#include "formats/text.h"

namespace phiz {
namespace {

using Json = nlohmann::json;

/// Adds the one mesh of `document` to `root`, its accessors and views behind those that are there.
void append_mesh(Json document, const std::string& name, Json& root, std::size_t bin_length) {
  const std::size_t first_view = root["bufferViews"].size(), first_accessor = root["accessors"].size();
  for (Json& view : document["bufferViews"]) {
    view["byteOffset"] = view.value("byteOffset", std::size_t{0}) + bin_length;
    root["bufferViews"].push_back(view);
  }
  for (Json& accessor : document["accessors"]) {
    accessor["bufferView"] = accessor["bufferView"].get<std::size_t>() + first_view;
    root["accessors"].push_back(accessor);
  }
  Json mesh = document["meshes"][0];
  mesh["name"] = name;
  Json& primitive = mesh["primitives"][0];
  for (auto& [semantic, accessor] : primitive["attributes"].items())
    accessor = accessor.get<std::size_t>() + first_accessor;
  primitive["indices"] = primitive["indices"].get<std::size_t>() + first_accessor;
  root["meshes"].push_back(mesh);
  Json node = document["nodes"][0];
  node["mesh"] = root["meshes"].size() - 1;
  node["name"] = name;
  root["nodes"].push_back(node);
}

}  // namespace

void write_lod_glb(const std::vector<TriangleMesh>& meshes, std::ostream& out) {
  if (meshes.empty()) throw FormatError("no level to write");
  Json root;
  std::string bin;
  for (std::size_t k = 0; k < meshes.size(); ++k) {
    std::ostringstream plain;
    write_glb(meshes[k], plain);
    const std::string bytes = std::move(plain).str();
    const GlbChunks chunks = split_glb(bytes);
    Json document = Json::parse(chunks.json);
    if (k == 0) {
      root = document;
      root["bufferViews"] = root["accessors"] = root["meshes"] = root["nodes"] = Json::array();
    }
    append_mesh(std::move(document), "head lod " + std::to_string(k), root, bin.size());
    bin += chunks.bin;
  }
  Json others = Json::array(), coverage = Json::array();
  for (std::size_t k = 0; k < meshes.size(); ++k) {
    if (k > 0) others.push_back(k);
    coverage.push_back(k + 1 == meshes.size() ? 0.0 : 0.5 / static_cast<double>(std::size_t{1} << (2 * k)));
  }
  if (!others.empty()) {
    root["nodes"][0]["extensions"]["MSFT_lod"]["ids"] = others;
    root["nodes"][0]["extras"]["MSFT_screencoverage"] = coverage;
    root["extensionsUsed"] = Json::array({"MSFT_lod"});
  }
  root["buffers"][0]["byteLength"] = bin.size();
  write_all(out, join_glb(root.dump(), bin));
}

}  // namespace phiz
