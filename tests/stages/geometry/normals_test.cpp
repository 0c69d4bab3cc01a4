#include "stages/geometry/normals.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "stages/geometry/angle.h"
#include "stages/geometry/parallel.h"
#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

std::vector<Eigen::Vector3d> to_double(const std::vector<Eigen::Vector3f>& points) {
  std::vector<Eigen::Vector3d> result;
  for (const Eigen::Vector3f& p : points) result.push_back(p.cast<double>());
  return result;
}

TEST(Normals, AngleAgreesWithTheLibrary) {
  test::Random& random = test::random();
  for (int i = 0; i < 20000; ++i) {
    const double scale = std::pow(10.0, random.uniform(-12, 12));
    const double y = scale * random.uniform(), x = scale * random.uniform(-1, 1);
    EXPECT_NEAR(angle_of(y, x), std::atan2(y, x), 1e-11);
  }
  EXPECT_EQ(angle_of(0, 0), 0);
  EXPECT_EQ(angle_of(0, 2), 0);
  EXPECT_EQ(angle_of(0, -2), std::numbers::pi);
  EXPECT_EQ(angle_of(3, 0), std::numbers::pi / 2);
}

TEST(Normals, AreRadialOnTheSphere) {
  const TriangleMesh mesh = test::icosphere(2);
  const auto normals = compute_vertex_normals(to_double(mesh.positions), mesh.triangles);
  for (std::size_t v = 0; v < normals.size(); ++v) {
    EXPECT_NEAR(normals[v].norm(), 1, 1e-14);
    EXPECT_GT(normals[v].dot(mesh.positions[v].cast<double>()), 0.9999);
  }
  const auto single = compute_vertex_normals(mesh.positions, mesh.triangles);
  for (std::size_t v = 0; v < normals.size(); ++v)
    EXPECT_LT((single[v].cast<double>() - normals[v]).norm(), 1e-6);
}

TEST(Normals, WeightsAreAnglesSoThatTheCutOfAFaceDoesNotMatter) {
  // The corner of a cube: one face is cut into two triangles at the corner, the others are whole or cut
  // elsewhere.
  const std::vector<Eigen::Vector3d> positions{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}};
  const std::vector<Eigen::Vector3i> triangles{{0, 2, 1}, {0, 3, 2}, {0, 1, 4}, {0, 4, 3}};
  const auto normals = compute_vertex_normals(positions, triangles);
  EXPECT_LT((normals[0] + Eigen::Vector3d::Ones().normalized()).norm(), 1e-10);
}

TEST(Normals, AreZeroWhereNoTriangleHasAnArea) {
  const std::vector<Eigen::Vector3d> positions{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {5, 5, 5}, {0, 1, 0}};
  const std::vector<Eigen::Vector3i> triangles{{0, 1, 2}, {0, 1, 4}};
  const auto normals = compute_vertex_normals(positions, triangles);
  EXPECT_EQ(normals[2], Eigen::Vector3d::Zero());
  EXPECT_EQ(normals[3], Eigen::Vector3d::Zero());
  EXPECT_EQ(normals[0], Eigen::Vector3d::UnitZ());
}

TEST(Normals, TurnWithTheMesh) {
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(-1.9, Eigen::Vector3d::UnitZ()))
          .toRotationMatrix();
  const TriangleMesh mesh = test::torus(12, 7);
  auto positions = to_double(mesh.positions);
  const auto before = compute_vertex_normals(positions, mesh.triangles);
  for (Eigen::Vector3d& p : positions) p = turn * (37.0 * p) + Eigen::Vector3d(5, -8, 13);
  const auto after = compute_vertex_normals(positions, mesh.triangles);
  for (std::size_t v = 0; v < before.size(); ++v) EXPECT_LT((turn * before[v] - after[v]).norm(), 1e-9);
}

TEST(Normals, HaveTheSameBitsAtAnyThreadCount) {
  const TriangleMesh mesh = test::icosphere(5);
  std::vector<Eigen::Vector3f> one, two;
  with_threads(1, [&] { one = compute_vertex_normals(mesh.positions, mesh.triangles); });
  with_threads(2, [&] { two = compute_vertex_normals(mesh.positions, mesh.triangles); });
  EXPECT_EQ(one, two);
}

}  // namespace
}  // namespace phiz
