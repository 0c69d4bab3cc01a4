#include "stages/unwrap/unwrap.h"

#include <gtest/gtest.h>

#include <sstream>

#include "formats/error.h"
#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "stages/geometry/surface_index.h"
#include "tests/stages/unwrap/uv_samples.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

struct Sheet {
  UvChart chart;
  std::vector<Eigen::Vector3d> positions;
};

Sheet make_sheet(int cells, int level) {
  const test::UvMesh mesh = test::random_uv_square(cells);
  Sheet sheet{make_uv_chart(mesh.uv, mesh.triangles, level), {}};
  sheet.positions = test::curved_sheet(sheet.chart.uv);
  return sheet;
}

std::string bytes_of(const GeometryImage& image) {
  std::ostringstream out;
  write_geometry_image(image, out);
  return out.str();
}

TEST(UvSurface, MeetsEveryVertexAndIsLinearInBetween) {
  const Sheet sheet = make_sheet(5, 2);
  const UvSurface surface(sheet.chart, sheet.positions);
  for (std::size_t v = 0; v < sheet.positions.size(); ++v)
    EXPECT_LT((surface.position_at(sheet.chart.uv[v]) - sheet.positions[v]).norm(), 1e-11);
  const auto& t = sheet.chart.hierarchy.triangles(2)[17];
  const Eigen::Vector3d weights(0.2, 0.5, 0.3);
  Eigen::Vector2d uv = Eigen::Vector2d::Zero();
  Eigen::Vector3d wanted = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    uv += weights[i] * sheet.chart.uv[t[i]];
    wanted += weights[i] * sheet.positions[t[i]];
  }
  EXPECT_LT((surface.position_at(uv) - wanted).norm(), 1e-11);
}

TEST(UvSurface, SlopesAreThoseOfAnAffineMap) {
  Sheet sheet = make_sheet(4, 1);
  const Eigen::Vector3d du(70, 3, -5), dv(2, 90, 8), origin(1, 2, 3);
  for (std::size_t v = 0; v < sheet.positions.size(); ++v)
    sheet.positions[v] = origin + sheet.chart.uv[v].x() * du + sheet.chart.uv[v].y() * dv;
  const UvSurface surface(sheet.chart, sheet.positions);
  const Eigen::Vector3d normal = du.cross(dv).normalized();
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d uv(test::random().uniform(), test::random().uniform());
    const UvSample sample = surface.evaluate(uv);
    EXPECT_LT((sample.position - (origin + uv.x() * du + uv.y() * dv)).norm(), 1e-10);
    EXPECT_LT((sample.du - du).norm(), 1e-8);
    EXPECT_LT((sample.dv - dv).norm(), 1e-8);
    EXPECT_LT((sample.normal - normal).norm(), 1e-10);
    EXPECT_LT((sample.tangent - du.normalized()).norm(), 1e-10);
    EXPECT_LT((sample.bitangent - normal.cross(sample.tangent)).norm(), 1e-12);
  }
}

TEST(UvSurface, FramesAreOrthonormalAndContinuous) {
  const Sheet sheet = make_sheet(6, 2);
  const UvSurface surface(sheet.chart, sheet.positions);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector2d uv(test::random().uniform(0.01, 0.99), test::random().uniform(0.01, 0.99));
    const UvSample here = surface.evaluate(uv), near = surface.evaluate(uv + Eigen::Vector2d(1e-7, -1e-7));
    Eigen::Matrix3d frame;
    frame << here.tangent, here.bitangent, here.normal;
    EXPECT_LT((frame.transpose() * frame - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_NEAR(frame.determinant(), 1, 1e-12);
    EXPECT_LT((here.tangent - near.tangent).norm() + (here.normal - near.normal).norm(), 1e-4);
  }
}

TEST(UvSurface, RefusesTheWrongNumberOfVertices) {
  const Sheet sheet = make_sheet(3, 1);
  EXPECT_THROW(UvSurface(sheet.chart, std::vector<Eigen::Vector3d>(5)), InvalidInput);
}

TEST(GeometryImage, NodesLieOnTheSurfaceAndBordersAreExact) {
  const Sheet sheet = make_sheet(4, 2);
  const UvSurface surface(sheet.chart, sheet.positions);
  const GeometryImage image = make_geometry_image(surface, {}, nullptr, {33, {}});
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Eigen::Vector3f wanted = surface.position_at(image.uv(x, y)).cast<float>();
      EXPECT_EQ(image.positions[y * image.width + x], wanted);
    }
  }
  EXPECT_EQ(image.uv(0, 0), Eigen::Vector2d(0, 1));
  EXPECT_EQ(image.uv(32, 32), Eigen::Vector2d(1, 0));
  // The four corners of the square are vertices of the sheet.
  EXPECT_LT((image.positions[32 * 33] - sheet.positions[0].cast<float>()).norm(), 1e-5f);
}

TEST(GeometryImage, TheFileAloneRebuildsTheSurface) {
  const Sheet sheet = make_sheet(4, 3);
  const UvSurface surface(sheet.chart, sheet.positions);
  std::istringstream file(bytes_of(make_geometry_image(surface, {}, nullptr, {129, {}})));
  const TriangleMesh grid = make_grid_mesh(read_geometry_image(file));
  const SurfaceIndex index(grid.positions, grid.triangles);
  for (const Eigen::Vector3d& p : sheet.positions) EXPECT_LT(index.find_nearest(p, 1e9)->distance, 0.02);
  for (const Eigen::Vector3i& t : grid.triangles) {
    const auto& p = grid.positions;
    EXPECT_GT((p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).dot(grid.normals[t[0]]), 0);
  }
}

TEST(GeometryImage, SameBytesAtAnyThreadCountAndAfterReading) {
  const Sheet sheet = make_sheet(5, 3);
  const UvSurface surface(sheet.chart, sheet.positions);
  const std::vector<std::uint8_t> confidences(sheet.positions.size(), 128);
  std::string one, many;
  with_threads(1, [&] { one = bytes_of(make_geometry_image(surface, confidences, nullptr, {100, {}})); });
  with_threads(4, [&] { many = bytes_of(make_geometry_image(surface, confidences, nullptr, {100, {}})); });
  EXPECT_EQ(one, many);
  std::istringstream file(one);
  const GeometryImage back = read_geometry_image(file);
  EXPECT_EQ(bytes_of(back), one);
  EXPECT_NEAR(back.confidences[123], 128 / 255.0, 1e-6);
}

TEST(GeometryImage, RefusesSidesBeyondMeasure) {
  const Sheet sheet = make_sheet(2, 0);
  const UvSurface surface(sheet.chart, sheet.positions);
  EXPECT_THROW(make_geometry_image(surface, {}, nullptr, {1, {}}), InvalidInput);
  EXPECT_THROW(make_geometry_image(surface, {}, nullptr, {100'000, {}}), InvalidInput);
}

}  // namespace
}  // namespace phiz
