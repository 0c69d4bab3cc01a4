#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/formats/scan_samples.h"

namespace phiz::test {
namespace {

int to_srgb(int linear_byte) {
  const double linear = linear_byte / 255.0;
  return static_cast<int>(
      255.0 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055) + 0.5);
}

void expect_sample(const ScanFile& scan, const ScanSample& sample) {
  EXPECT_EQ(scan.format, "glb");
  EXPECT_EQ(scan.points.positions, sample.positions);
  EXPECT_EQ(scan.triangles, sample.triangles);
  ASSERT_EQ(scan.points.normals.size(), sample.normals.size());
  ASSERT_EQ(scan.points.colours.size(), sample.colours.size());
  for (std::size_t i = 0; i < sample.normals.size(); ++i) {
    EXPECT_LT((scan.points.normals[i] - sample.normals[i]).norm(), 1e-6f);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(scan.points.colours[i][k], to_srgb(sample.colours[i][k]));
  }
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// The sample with a part of its JSON replaced.
std::string changed(const std::string& from, const std::string& to) {
  const std::string glb = write_glb(make_sample());
  std::uint32_t json_size = 0;
  std::memcpy(&json_size, glb.data() + 12, 4);
  return glb_of(replaced(glb.substr(20, json_size), from, to), glb.substr(28 + json_size));
}

std::string floats(std::initializer_list<float> values) {
  std::string bytes(4 * values.size(), '\0');
  std::memcpy(bytes.data(), values.begin(), bytes.size());
  return bytes;
}

/// One right triangle, its node and the scene as given.
std::string triangle_glb(const std::string& nodes, const std::string& primitive = "") {
  return glb_of(
      R"({"asset":{"version":"2.0"},"nodes":)" + nodes +
          R"(,"buffers":[{"byteLength":72}],"bufferViews":[{"buffer":0,"byteLength":72}],"accessors":[)"
          R"({"bufferView":0,"count":3,"componentType":5126,"type":"VEC3"},)"
          R"({"bufferView":0,"byteOffset":36,"count":3,"componentType":5126,"type":"VEC3"}],)"
          R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1})" +
          primitive + "}]}]}",
      floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0.6f, 0.8f, 0, 0, 1, 0, 0, 1}));
}

TEST(ScanGlb, GivesBackPositionsNormalsColoursAndTriangles) {
  const ScanSample sample = make_sample();
  expect_sample(parse(write_glb(sample)), sample);
}

TEST(ScanGlb, ReadsDraco) {
  const ScanSample sample = make_sample();
  expect_sample(parse(write_draco_glb(sample)), sample);
}

TEST(ScanGlb, AppliesTheTransformsOfNodes) {
  const std::string moved =
      R"([{"children":[1],"translation":[10,20,30]},)"
      R"({"mesh":0,"rotation":[0,0,0.70710678118654752,0.70710678118654752],"scale":[2,2,1]}])";
  const std::string by_matrix = R"([{"mesh":0,"matrix":[0,2,0,0, -2,0,0,0, 0,0,1,0, 10,20,30,1]}])";
  for (const std::string& nodes : {moved, by_matrix}) {
    const ScanFile scan = parse(triangle_glb(nodes));
    const std::vector<Eigen::Vector3d> positions = true_positions(scan);
    ASSERT_EQ(positions.size(), 3u);
    EXPECT_LT((positions[1] - Eigen::Vector3d(10, 22, 30)).norm(), 1e-5);
    EXPECT_LT((positions[2] - Eigen::Vector3d(8, 20, 30)).norm(), 1e-5);
    // The normal (0, 0.6, 0.8) under the inverse transpose: turned to (-0.6, 0, 0.8), x halved.
    EXPECT_LT((scan.points.normals.at(0) - Eigen::Vector3f(-0.3f, 0, 0.8f).normalized()).norm(), 1e-6f);
  }
}

TEST(ScanGlb, TurnsTrianglesOfAMirroredNode) {
  const ScanFile scan = parse(triangle_glb(R"([{"mesh":0,"scale":[-1,1,1]}])"));
  EXPECT_EQ(scan.triangles.at(0), Eigen::Vector3i(0, 2, 1));
  EXPECT_LT((scan.points.normals.at(1) - Eigen::Vector3f(0, 0, 1)).norm(), 1e-6f);
}

TEST(ScanGlb, KnowsTheModesOfPrimitives) {
  const std::string node = R"([{"mesh":0}])";
  EXPECT_EQ(parse(triangle_glb(node, R"(,"mode":0)")).triangles.size(), 0u);
  EXPECT_EQ(parse(triangle_glb(node, R"(,"mode":0)")).points.size(), 3u);
  EXPECT_EQ(parse(triangle_glb(node, R"(,"mode":5)")).triangles.size(), 1u);
  EXPECT_EQ(parse(triangle_glb(node, R"(,"mode":6)")).triangles.at(0), Eigen::Vector3i(0, 1, 2));
}

TEST(ScanGlb, TakesSharedVerticesOnce) {
  const ScanFile scan = parse(
      changed(R"("indices":3}])", R"("indices":3},{"attributes":{"POSITION":0,"NORMAL":1,"COLOR_0":2}}])"));
  EXPECT_EQ(scan.points.size(), 42u);
  EXPECT_EQ(scan.triangles.size(), 80u + 14u);
}

TEST(ScanGlb, RefusesWhatIsOutsideTheFileWithAdvice) {
  EXPECT_NE(
      fault_of(changed(R"("buffers":[{)", R"("buffers":[{"uri":"head.bin",)")).find("export as one .glb"),
      std::string::npos);
  EXPECT_NE(
      fault_of(changed(R"("buffers":[{)", R"("buffers":[{"uri":"data:,x",)")).find("export as one .glb"),
      std::string::npos);
  EXPECT_NE(fault_of(R"({"asset":{"version":"2.0"}})", ".gltf").find("export as one .glb"),
            std::string::npos);
}

TEST(ScanGlb, RefusesLyingNumbers) {
  const std::pair<const char*, const char*> lies[] = {
      {R"("count":42)", R"("count":4000000000)"},
      {R"("count":42)", R"("count":-1)"},
      {R"("count":42)", R"("count":1e300)"},
      {R"("count":42)", R"("count":"many")"},
      {R"("byteLength":1176)", R"("byteLength":1)"},
      {R"("byteStride":28)", R"("byteStride":29)"},
      {R"("byteOffset":24)", R"("byteOffset":9007199254740991)"},
      {R"("componentType":5126)", R"("componentType":1)"},
      {R"("VEC3")", R"("VEC2")"},
      {R"("indices":3)", R"("indices":9)"},
      {R"("mesh":0)", R"("mesh":7)"},
      {R"("mesh":0)", R"("mesh":0,"children":[0])"},
      {R"([{"mesh":0}])", R"([{"mesh":0,"matrix":[1]}])"},
      {R"("nodes":[0])", R"("nodes":[0,0])"},
      {R"("nodes":[0])", R"("nodes":{})"},
      {R"("POSITION":0)", R"("POSITION":3)"}};
  for (const auto& [from, to] : lies) EXPECT_NE(fault_of(changed(from, to)), "") << to;
}

TEST(ScanGlb, RefusesMoreInstancesThanAFileCanMean) {
  std::string nodes = R"([{"mesh":0})";
  for (int i = 0; i < 20000; ++i) nodes += R"(,{"mesh":0})";
  EXPECT_EQ(fault_of(triangle_glb(nodes + "]")), "") << "small ones are fine";
  ScanLimits limits;
  limits.max_points = 1000;
  EXPECT_NE(fault_of(triangle_glb(nodes + "]"), "", limits).find("allowed"), std::string::npos);
}

}  // namespace
}  // namespace phiz::test
