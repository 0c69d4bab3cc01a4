#include "formats/animated_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/error.h"
#include "formats/glb_chunks.h"
#include "formats/scan_file.h"
#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

AnimatedMesh sample() {
  AnimatedMesh animated;
  animated.mesh = test::icosphere(1);
  for (const char* name : {"smile", "still", "jaw"}) {
    MorphTarget target{name, {}, {}};
    for (int v = 0; v < 42 && target.name != "still"; v += 1 + static_cast<int>(test::random().below(4))) {
      target.vertices.push_back(v);
      target.offsets.emplace_back(test::random().normal(), test::random().normal(), test::random().normal());
    }
    animated.targets.push_back(target);
  }
  for (int i = 0; i < 5; ++i) {
    animated.times_s.push_back(0.1f * static_cast<float>(i));
    for (int t = 0; t < 3; ++t) animated.weights.push_back(static_cast<float>(test::random().uniform()));
  }
  return animated;
}

template <typename Value>
std::vector<Value> values_of(const nlohmann::json& document, const GlbChunks& chunks,
                             const nlohmann::json& view_idx, std::size_t count) {
  const nlohmann::json& view = document["bufferViews"][view_idx.get<std::size_t>()];
  EXPECT_EQ(view["byteLength"].get<std::size_t>(), count * sizeof(Value));
  std::vector<Value> values(count);
  std::memcpy(static_cast<void*>(values.data()), chunks.bin.data() + view["byteOffset"].get<std::size_t>(),
              count * sizeof(Value));
  return values;
}

TEST(AnimatedMesh, TargetsAndWeightsStandInTheFile) {
  const AnimatedMesh animated = sample();
  std::ostringstream out;
  write_animated_glb(animated, out);
  const std::string bytes = out.str();
  const GlbChunks chunks = split_glb(bytes);
  const nlohmann::json document = nlohmann::json::parse(chunks.json);
  const nlohmann::json& mesh = document["meshes"][0];
  EXPECT_EQ(mesh["extras"]["targetNames"], (std::vector<std::string>{"smile", "still", "jaw"}));
  EXPECT_EQ(mesh["weights"].size(), 3u);
  for (std::size_t t = 0; t < 3; ++t) {
    const nlohmann::json& accessor =
        document["accessors"][mesh["primitives"][0]["targets"][t]["POSITION"].get<std::size_t>()];
    EXPECT_EQ(accessor["count"], 42);
    EXPECT_TRUE(accessor.contains("min"));
    const MorphTarget& target = animated.targets[t];
    EXPECT_EQ(accessor.contains("sparse"), !target.vertices.empty());
    if (target.vertices.empty()) continue;
    const auto vertices = values_of<std::uint16_t>(
        document, chunks, accessor["sparse"]["indices"]["bufferView"], target.vertices.size());
    EXPECT_EQ(std::vector<int>(vertices.begin(), vertices.end()), target.vertices);
    EXPECT_EQ(values_of<Eigen::Vector3f>(document, chunks, accessor["sparse"]["values"]["bufferView"],
                                         target.offsets.size()),
              target.offsets);
  }
  const nlohmann::json& sampler = document["animations"][0]["samplers"][0];
  EXPECT_EQ(document["animations"][0]["channels"][0]["target"]["path"], "weights");
  EXPECT_EQ(values_of<float>(document, chunks,
                             document["accessors"][sampler["output"].get<std::size_t>()]["bufferView"], 15),
            animated.weights);
}

TEST(AnimatedMesh, IsStillAMeshForOurReader) {
  const AnimatedMesh animated = sample();
  std::ostringstream out;
  write_animated_glb(animated, out);
  const std::string bytes = out.str();
  EXPECT_EQ(parse_scan(std::as_bytes(std::span(bytes)), ".glb").points.size(), 42u);
}

TEST(AnimatedMesh, RefusesWhatDoesNotBelongTogether) {
  const auto refuse = [](auto spoil) {
    AnimatedMesh animated = sample();
    spoil(animated);
    std::ostringstream out;
    EXPECT_THROW(write_animated_glb(animated, out), FormatError);
    EXPECT_TRUE(out.str().empty());
  };
  refuse([](AnimatedMesh& a) { a.weights.pop_back(); });
  refuse([](AnimatedMesh& a) { a.weights[2] = NAN; });
  refuse([](AnimatedMesh& a) { a.times_s[3] = 0; });
  refuse([](AnimatedMesh& a) { a.targets[0].vertices.back() = 42; });
  refuse([](AnimatedMesh& a) { a.targets[0].vertices[1] = 0; });
  refuse([](AnimatedMesh& a) { a.targets[0].offsets.pop_back(); });
  refuse([](AnimatedMesh& a) { a.mesh.triangles.clear(); });
}

}  // namespace
}  // namespace phiz
