#include "formats/triangle_mesh.h"

#include <gtest/gtest.h>

#include <cstring>
#include <sstream>

#include "formats/error.h"
#include "tests/support/mesh_zoo.h"

namespace phiz {
namespace {

TriangleMesh dressed_sphere() {
  TriangleMesh mesh = test::icosphere(1);
  for (const Eigen::Vector3f& p : mesh.positions) {
    mesh.normals.push_back(p.normalized());
    mesh.uv.emplace_back(0.5f + 0.5f * p.x(), 0.5f - 0.5f * p.y());
    mesh.colours.push_back({static_cast<std::uint8_t>(mesh.colours.size()), 128, 255});
  }
  return mesh;
}

template <typename Write>
std::string written(const TriangleMesh& mesh, Write write) {
  std::ostringstream out;
  write(mesh, out);
  return out.str();
}

TEST(TriangleMesh, PlyHoldsEveryNumberBitForBit) {
  const TriangleMesh mesh = dressed_sphere();
  const std::string bytes = written(mesh, write_ply);
  const std::size_t begin = bytes.find("end_header\n") + 11;
  constexpr std::size_t kRow = 8 * sizeof(float) + 3;
  ASSERT_EQ(bytes.size(), begin + mesh.vertex_count() * kRow + mesh.triangle_count() * 13);
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    const char* row = bytes.data() + begin + i * kRow;
    EXPECT_EQ(std::memcmp(row, mesh.positions[i].data(), 12), 0);
    EXPECT_EQ(std::memcmp(row + 12, mesh.normals[i].data(), 12), 0);
    EXPECT_EQ(std::memcmp(row + 24, mesh.uv[i].data(), 8), 0);
    EXPECT_EQ(std::memcmp(row + 32, mesh.colours[i].data(), 3), 0);
  }
  const char* faces = bytes.data() + begin + mesh.vertex_count() * kRow;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    EXPECT_EQ(faces[t * 13], 3);
    EXPECT_EQ(std::memcmp(faces + t * 13 + 1, mesh.triangles[t].data(), 12), 0);
  }
}

TEST(TriangleMesh, ObjHoldsEveryFloatExactly) {
  TriangleMesh mesh = dressed_sphere();
  mesh.colours.clear();
  std::istringstream in(written(mesh, write_obj));
  std::size_t positions = 0, uvs = 0, normals = 0, faces = 0;
  for (std::string keyword; in >> keyword;) {
    if (keyword == "v" || keyword == "vn") {
      Eigen::Vector3f read;
      in >> read.x() >> read.y() >> read.z();
      EXPECT_EQ(read, keyword == "v" ? mesh.positions[positions++] : mesh.normals[normals++]);
    } else if (keyword == "vt") {
      Eigen::Vector2f read;
      in >> read.x() >> read.y();
      EXPECT_EQ(read, mesh.uv[uvs++]);
    } else {
      ASSERT_EQ(keyword, "f");
      for (int k = 0; k < 3; ++k) {
        std::string corner;
        in >> corner;
        const std::string index = std::to_string(mesh.triangles[faces][k] + 1);
        EXPECT_EQ(corner, index + "/" + index + "/" + index);
      }
      ++faces;
    }
  }
  EXPECT_EQ(positions, mesh.vertex_count());
  EXPECT_EQ(uvs, mesh.vertex_count());
  EXPECT_EQ(normals, mesh.vertex_count());
  EXPECT_EQ(faces, mesh.triangle_count());
}

TEST(TriangleMesh, ObjOfBarePositionsHasBareFaces) {
  const std::string text = written(test::single_triangle(), write_obj);
  EXPECT_NE(text.find("f 1 2 3\n"), std::string::npos);
}

TEST(TriangleMesh, WritersRefuseABrokenMesh) {
  const auto refused = [](const TriangleMesh& mesh) {
    EXPECT_THROW(written(mesh, write_ply), FormatError);
    EXPECT_THROW(written(mesh, write_obj), FormatError);
  };
  TriangleMesh mesh = dressed_sphere();
  mesh.positions[2].x() = std::numeric_limits<float>::infinity();
  refused(mesh);
  mesh = dressed_sphere();
  mesh.triangles[1][2] = static_cast<int>(mesh.vertex_count());
  refused(mesh);
  mesh = dressed_sphere();
  mesh.uv.pop_back();
  refused(mesh);
  mesh = dressed_sphere();
  mesh.colours.pop_back();
  refused(mesh);
}

TEST(TriangleMesh, AnUnwritableStreamIsAnError) {
  std::ostringstream out;
  out.setstate(std::ios::badbit);
  EXPECT_THROW(write_ply(test::single_triangle(), out), FormatError);
  EXPECT_THROW(write_obj(test::single_triangle(), out), FormatError);
}

}  // namespace
}  // namespace phiz
