#include "stages/align/mesh_silhouette.h"

#include <gtest/gtest.h>

#include <limits>

#include "stages/align/silhouette_osmesa.h"
#include "stages/geometry/error.h"
#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using test::random;

const AffineMatrix kIdentity = AffineMatrix::Identity();

AffineMatrix random_affine(double scale) {
  AffineMatrix m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m(i, j) = scale * random().uniform(-1, 1);
  for (int i = 0; i < 3; ++i) m(i, 3) = random().uniform(-20, 20);
  return m;
}

// The mesh moved and put on the grid of 1/256 mm: with pixels of 1 mm its fixed-point coordinates are then
// exact.
TriangleMesh place(TriangleMesh mesh, const AffineMatrix& m) {
  for (Eigen::Vector3f& p : mesh.positions) {
    const Eigen::Vector3d moved = m * p.cast<double>().homogeneous();
    p = (moved * 256).array().round().matrix().cast<float>() / 256;
  }
  return mesh;
}

// The rule itself, a triangle and a pixel at a time: centre inside, or on a top or left edge.
Silhouette draw_each_triangle(const TriangleMesh& mesh, ViewAxis axis, const SilhouetteFrame& frame) {
  Silhouette out(frame.size);
  for (const Eigen::Vector3i& t : mesh.triangles) {
    std::array<Eigen::Matrix<std::int64_t, 2, 1>, 3> p;
    for (int k = 0; k < 3; ++k)
      p[k] = (frame.project(mesh.positions[t[k]].cast<double>(), axis) * 256)
                 .array()
                 .round()
                 .matrix()
                 .cast<std::int64_t>();
    const auto cross = [](const auto& u, const auto& v) { return u.x() * v.y() - u.y() * v.x(); };
    if (cross(p[1] - p[0], p[2] - p[0]) == 0) continue;
    if (cross(p[1] - p[0], p[2] - p[0]) < 0) std::swap(p[1], p[2]);
    for (int y = 0; y < frame.size; ++y)
      for (int x = 0; x < frame.size; ++x) {
        const Eigen::Matrix<std::int64_t, 2, 1> centre(x * 256 + 128, y * 256 + 128);
        bool inside = true;
        for (int k = 0; k < 3 && inside; ++k) {
          const Eigen::Matrix<std::int64_t, 2, 1> edge = p[(k + 1) % 3] - p[k];
          const bool top_or_left = edge.y() < 0 || (edge.y() == 0 && edge.x() > 0);
          const std::int64_t side = cross(edge, centre - p[k]);
          inside = side > 0 || (side == 0 && top_or_left);
        }
        if (inside) out.fill_span(y, x, x + 1);
      }
  }
  return out;
}

SilhouetteFrame small_frame() {
  return {Eigen::Vector3d::Zero(), 1.0, 64};
}

void expect_union_of_triangles(const TriangleMesh& mesh, const std::string& what) {
  SilhouetteRasteriser rasteriser;
  Silhouette drawn;
  for (const ViewAxis axis : kViewAxes) {
    rasteriser.rasterise(SilhouetteMesh(mesh.positions, mesh.triangles), kIdentity, axis, small_frame(),
                         drawn);
    EXPECT_EQ(count_xor(drawn, draw_each_triangle(mesh, axis, small_frame())), 0)
        << what << ", view " << static_cast<int>(axis);
  }
}

TEST(MeshSilhouette, IsTheUnionOfItsTrianglesOnTheMeshZoo) {
  for (const auto& [name, mesh] : test::mesh_zoo())
    for (int k = 0; k < 3; ++k) expect_union_of_triangles(place(mesh, random_affine(25)), name);
}

TEST(MeshSilhouette, IsTheUnionOfItsTrianglesForASoup) {
  for (int k = 0; k < 10; ++k) {
    TriangleMesh soup;  // shared vertices, any orientation, edges of many triangles, repeated corners
    for (int i = 0; i < 12; ++i)
      soup.positions.emplace_back(random().uniform(-40, 40), random().uniform(-40, 40),
                                  random().uniform(-40, 40));
    for (int i = 0; i < 20; ++i)
      soup.triangles.emplace_back(random().below(12), random().below(12), random().below(12));
    expect_union_of_triangles(place(soup, kIdentity), "soup " + std::to_string(k));
  }
}

TEST(MeshSilhouette, CentresOnEdgesFollowTheTopLeftRule) {
  TriangleMesh square = test::open_grid(4, 4);  // all edges run through pixel centres
  AffineMatrix m = kIdentity * 1.0;
  m.leftCols<3>() *= 16;
  m.col(3) << -8.5, -8.5, 0;
  square = place(square, m);
  expect_union_of_triangles(square, "grid on pixel centres");
  SilhouetteRasteriser rasteriser;
  Silhouette drawn;
  rasteriser.rasterise(SilhouetteMesh(square.positions, square.triangles), kIdentity, ViewAxis::kFront,
                       small_frame(), drawn);
  EXPECT_EQ(count_pixels(drawn), 16 * 16);
}

TEST(MeshSilhouette, ThreeAtOnceAreTheThreeViews) {
  const TriangleMesh mesh = test::torus(24, 12);
  const SilhouetteMesh prepared(mesh.positions, mesh.triangles);
  SilhouetteRasteriser rasteriser;
  std::array<Silhouette, 3> all;
  for (int k = 0; k < 5; ++k) {
    const AffineMatrix m = random_affine(20);
    rasteriser.rasterise(prepared, m, small_frame(), all);
    for (std::size_t view = 0; view < 3; ++view) {
      Silhouette one;
      rasteriser.rasterise(prepared, m, kViewAxes[view], small_frame(), one);
      EXPECT_EQ(one, all[view]);
      EXPECT_GT(count_pixels(one), 0);
    }
  }
}

TEST(MeshSilhouette, ADiscCoversItsAreaAndSoDoesASphere) {
  const TriangleMesh sphere = test::icosphere(4);
  const SilhouetteMesh prepared(sphere.positions, sphere.triangles);
  SilhouetteRasteriser rasteriser;
  Silhouette drawn;
  AffineMatrix m = kIdentity * 1.0;
  m.leftCols<3>() *= 100;
  for (const ViewAxis axis : kViewAxes) {
    rasteriser.rasterise(prepared, m, axis, SilhouetteFrame{}, drawn);
    EXPECT_NEAR(static_cast<double>(count_pixels(drawn)), 3.14159265 * 100 * 100, 150);
  }
}

TEST(MeshSilhouette, WhatLiesOutsideThePictureIsClipped) {
  const TriangleMesh sphere = test::icosphere(2);
  const SilhouetteMesh prepared(sphere.positions, sphere.triangles);
  SilhouetteRasteriser rasteriser;
  Silhouette drawn;
  AffineMatrix m = kIdentity * 1.0;
  m.leftCols<3>() *= 200;
  rasteriser.rasterise(prepared, m, ViewAxis::kFront, small_frame(), drawn);
  EXPECT_EQ(count_pixels(drawn), 64 * 64);
  m.col(3) << 1000, 0, 0;
  rasteriser.rasterise(prepared, m, ViewAxis::kFront, small_frame(), drawn);
  EXPECT_EQ(count_pixels(drawn), 0);
  m.col(3) << 200, 1e300, std::numeric_limits<double>::quiet_NaN();
  rasteriser.rasterise(prepared, m, ViewAxis::kSide, small_frame(), drawn);
  EXPECT_EQ(count_pixels(drawn), 0);
}

TEST(MeshSilhouette, RefusesBrokenMeshes) {
  TriangleMesh mesh = test::tetrahedron();
  mesh.triangles[2][1] = 4;
  EXPECT_THROW(SilhouetteMesh(mesh.positions, mesh.triangles), InvalidInput);
  mesh = test::tetrahedron();
  mesh.positions[1].y() = std::numeric_limits<float>::infinity();
  EXPECT_THROW(SilhouetteMesh(mesh.positions, mesh.triangles), InvalidInput);
}

// Both round to 1/256 pixel; where a coordinate lies half-way they may differ by one step.
TEST(MeshSilhouette, AgreesWithOsmesa) {
  SilhouetteRasteriser rasteriser;
  for (const int size : {256, 512}) {
    OsmesaSilhouettes osmesa(size);
    const SilhouetteFrame frame{Eigen::Vector3d(3, -2, 5), 256.0 / size, size};
    for (const auto& mesh : {test::icosphere(3), test::torus(40, 20), test::open_grid(9, 7)}) {
      const SilhouetteMesh prepared(mesh.positions, mesh.triangles);
      const AffineMatrix m = random_affine(60);
      for (const ViewAxis axis : kViewAxes) {
        Silhouette drawn;
        rasteriser.rasterise(prepared, m, axis, frame, drawn);
        const Silhouette reference = osmesa.rasterise(mesh.positions, mesh.triangles, m, axis, frame);
        EXPECT_LE(static_cast<double>(count_xor(drawn, reference)),
                  1 + 5e-4 * static_cast<double>(count_pixels(reference)));
      }
    }
  }
}

}  // namespace
}  // namespace phiz
