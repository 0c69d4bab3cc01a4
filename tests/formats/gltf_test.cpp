#include "formats/gltf.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/error.h"
#include "formats/glb_chunks.h"
#include "formats/scan_file.h"
#include "tests/support/mesh_zoo.h"

namespace phiz {
namespace {

TriangleMesh dressed_sphere() {
  TriangleMesh mesh = test::icosphere(2);
  for (Eigen::Vector3f& p : mesh.positions) {
    mesh.normals.push_back(p);
    mesh.uv.emplace_back(0.5f + 0.5f * p.x(), 0.5f - 0.5f * p.y());
    mesh.colours.push_back({static_cast<std::uint8_t>(mesh.colours.size()), 128, 255});
    p = 100.0f * p + Eigen::Vector3f(3.0f, 0.0f, -7.0f);
  }
  return mesh;
}

template <typename Write>
std::string written(const TriangleMesh& mesh, Write write) {
  std::ostringstream out;
  write(mesh, out);
  return out.str();
}

ScanFile parse(const std::string& bytes, const char* extension) {
  return parse_scan(std::as_bytes(std::span(bytes)), extension);
}

TEST(Gltf, OurOwnReaderFindsTheMeshInMetres) {
  const TriangleMesh mesh = dressed_sphere();
  const ScanFile scan = parse(written(mesh, write_glb), ".glb");
  EXPECT_EQ(scan.triangles, mesh.triangles);
  ASSERT_EQ(scan.points.size(), mesh.vertex_count());
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    const Eigen::Vector3d position = scan.origin + scan.points.positions[i].cast<double>();
    EXPECT_LE((position * 1000.0 - mesh.positions[i].cast<double>()).norm(), 1e-4);
    EXPECT_EQ(scan.points.colours[i], mesh.colours[i]);
    EXPECT_LE((scan.points.normals[i] - mesh.normals[i]).norm(), 1e-5f);
  }
}

TEST(Gltf, GlbHoldsPositionsAndIndicesBitForBit) {
  const TriangleMesh mesh = dressed_sphere();
  const std::string bytes = written(mesh, write_glb);
  const GlbChunks chunks = split_glb(bytes);
  EXPECT_EQ(std::memcmp(chunks.bin.data(), mesh.positions.data(), 12 * mesh.vertex_count()), 0);
  const std::size_t index_bytes = 12 * mesh.triangle_count();
  EXPECT_EQ(
      std::memcmp(chunks.bin.data() + chunks.bin.size() - index_bytes, mesh.triangles.data(), index_bytes),
      0);
  EXPECT_TRUE(written(mesh, write_glb) == bytes);
}

TEST(Gltf, DracoKeepsOrderAndAlmostEveryNumber) {
  const TriangleMesh mesh = dressed_sphere();
  const std::string bytes = written(mesh, write_drc);
  const ScanFile scan = parse(bytes, ".drc");
  EXPECT_EQ(scan.triangles, mesh.triangles);
  ASSERT_EQ(scan.points.size(), mesh.vertex_count());
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    const Eigen::Vector3d position = scan.origin + scan.points.positions[i].cast<double>();
    EXPECT_LE((position - mesh.positions[i].cast<double>()).cwiseAbs().maxCoeff(), 0.51 * 200.0 / 65535.0);
    EXPECT_EQ(scan.points.colours[i], mesh.colours[i]);
  }
  EXPECT_TRUE(written(mesh, write_drc) == bytes);
}

TEST(Gltf, AZeroNormalAndPointsAloneAreWritten) {
  TriangleMesh mesh = dressed_sphere();
  mesh.normals[3].setZero();
  mesh.triangles.clear();
  const ScanFile scan = parse(written(mesh, write_glb), ".glb");
  EXPECT_EQ(scan.points.size(), mesh.vertex_count());
  EXPECT_EQ(scan.points.normals[3], Eigen::Vector3f(0, 1, 0));
  EXPECT_THROW(written(mesh, write_drc), FormatError);
}

TEST(Gltf, RefusesABrokenMesh) {
  TriangleMesh mesh = dressed_sphere();
  mesh.positions[1].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(written(mesh, write_glb), FormatError);
  EXPECT_THROW(written(mesh, write_drc), FormatError);
  EXPECT_THROW(written(TriangleMesh{}, write_glb), FormatError);
  EXPECT_THROW(written(TriangleMesh{}, write_drc), FormatError);
}

TEST(Gltf, LevelsOfDetailNameEachOtherAndKeepTheirMeshes) {
  const std::vector<TriangleMesh> meshes = {test::disk(8, 6), test::disk(8, 3), test::disk(8, 1)};
  std::ostringstream out;
  write_lod_glb(meshes, out);
  const std::string bytes = out.str();
  const nlohmann::json document = nlohmann::json::parse(split_glb(bytes).json);
  EXPECT_EQ(document["scenes"][0]["nodes"], (std::vector<int>{0}));
  EXPECT_EQ(document["nodes"][0]["extensions"]["MSFT_lod"]["ids"], (std::vector<int>{1, 2}));
  EXPECT_EQ(document["nodes"][0]["extras"]["MSFT_screencoverage"].size(), 3u);
  for (std::size_t k = 0; k < meshes.size(); ++k) {
    const nlohmann::json& primitive =
        document["meshes"][document["nodes"][k]["mesh"].get<std::size_t>()]["primitives"][0];
    EXPECT_EQ(document["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()]["count"],
              meshes[k].vertex_count());
    EXPECT_EQ(document["accessors"][primitive["indices"].get<std::size_t>()]["count"],
              3 * meshes[k].triangle_count());
  }
}

}  // namespace
}  // namespace phiz
