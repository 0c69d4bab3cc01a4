#include "stages/geometry/distance_lattice.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <memory>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using test::random;

Eigen::Vector3f random_point(float size) {
  return {size * static_cast<float>(random().uniform(-1, 1)),
          size * static_cast<float>(random().uniform(-1, 1)),
          size * static_cast<float>(random().uniform(-1, 1))};
}

std::vector<Eigen::Vector3f> sphere_points(int count, float radius) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d d(random().normal(), random().normal(), random().normal());
    points.push_back(radius * d.normalized().cast<float>());
  }
  return points;
}

float brute_force(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& p) {
  float least = std::numeric_limits<float>::max();
  for (const auto& q : points) least = std::min(least, (p - q).norm());
  return least;
}

TEST(DistanceLattice, AgreesWithBruteForceToAboutHalfACell) {
  for (const int count : {1, 7, 300}) {
    const auto points = sphere_points(count, 10.0f);
    const DistanceLattice lattice(points, 5.0f, 64);
    double sum = 0;
    constexpr int kReads = 1500;
    for (int i = 0; i < kReads; ++i) {
      const Eigen::Vector3f p = random_point(12.0f);
      if (count < 300 && brute_force(points, p) > 20) continue;
      Eigen::AlignedBox3f box;
      for (const auto& q : points) box.extend(q);
      if (box.exteriorDistance(p) > 2.5f) continue;  // outside the lattice or nearly
      const float error = std::abs(lattice.at(p).distance - brute_force(points, p));
      ASSERT_LT(error, 1.2f * lattice.cell()) << p.transpose();
      sum += error;
    }
    EXPECT_LT(sum / kReads, 0.5 * lattice.cell());
  }
}

TEST(DistanceLattice, IsExactOnItsOwnPlaces) {
  // The box of these points is [-4, 12] along x: cells of one unit, all points on lattice places.
  std::vector<Eigen::Vector3f> points = {{0, 0, 0}, {8, 0, 0}, {3, 5, 1}, {2, 7, 8}, {6, 2, 4}};
  const DistanceLattice lattice(points, 4.0f, 16);
  ASSERT_EQ(lattice.cell(), 1.0f);
  for (int z = -4; z < 12; ++z)
    for (int y = -4; y < 11; ++y)
      for (int x = -4; x < 12; ++x) {
        const Eigen::Vector3f p(x, y, z);
        ASSERT_NEAR(lattice.at(p).distance, brute_force(points, p), 1e-5f) << p.transpose();
      }
}

TEST(DistanceLattice, GradientIsTheFiniteDifference) {
  const auto points = sphere_points(200, 10.0f);
  const DistanceLattice lattice(points, 5.0f, 48);
  const float h = 0.002f * lattice.cell();
  int compared = 0;
  for (int i = 0; i < 800; ++i) {
    const Eigen::Vector3f p = random_point(i % 2 ? 12.0f : 40.0f);  // inside and outside the box
    const auto here = lattice.at(p);
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3f step = h * Eigen::Vector3f::Unit(axis);
      const float right = (lattice.at(p + step).distance - here.distance) / h,
                  left = (here.distance - lattice.at(p - step).distance) / h;
      if (std::abs(right - left) > 0.05f) continue;  // a cell border lies between
      EXPECT_NEAR(here.gradient[axis], 0.5f * (right + left), 0.03f) << p.transpose();
      ++compared;
    }
  }
  EXPECT_GT(compared, 2000);
}

TEST(DistanceLattice, GrowsByTheWayOutsideItsBox) {
  const std::vector<Eigen::Vector3f> points = {{0, 0, 0}, {1, 0, 0}};
  const DistanceLattice lattice(points, 2.0f, 50);
  const float near = lattice.at({100, 0, 0}).distance, far = lattice.at({150, 0, 0}).distance;
  EXPECT_NEAR(far - near, 50.0f, 1e-3f);
  EXPECT_NEAR(near, 99.0f, 2 * lattice.cell());
  EXPECT_NEAR(lattice.at({100, 0, 0}).gradient.x(), 1.0f, 1e-3f);
}

TEST(DistanceLattice, PointsInAPlaneOrAtOnePlaceNeedNoMargin) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 100; ++i) points.emplace_back(i % 10, i / 10, 3.0f);
  const DistanceLattice flat(points, 0.0f, 36);
  EXPECT_NEAR(flat.at({4, 4, 3}).distance, 0.0f, 1e-4f);
  EXPECT_NEAR(flat.at({4, 4, 8}).distance, 5.0f, 2 * flat.cell());
  const DistanceLattice point(std::vector<Eigen::Vector3f>{{1, 2, 3}}, 0.0f, 8);
  EXPECT_NEAR(point.at({1, 2, 7}).distance, 4.0f, 1e-4f);
}

TEST(DistanceLattice, SameBitsAtAnyThreadCount) {
  const auto points = sphere_points(500, 10.0f);
  std::unique_ptr<DistanceLattice> one, two;
  with_threads(1, [&] { one = std::make_unique<DistanceLattice>(points, 5.0f, 64); });
  with_threads(2, [&] { two = std::make_unique<DistanceLattice>(points, 5.0f, 64); });
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3f p = random_point(14.0f);
    ASSERT_EQ(one->at(p).distance, two->at(p).distance);
    ASSERT_EQ(one->at(p).gradient, two->at(p).gradient);
  }
}

TEST(DistanceLattice, RefusesNothing) {
  EXPECT_THROW(DistanceLattice({}, 1.0f, 10), ContractViolation);
  EXPECT_THROW(DistanceLattice(std::vector<Eigen::Vector3f>{{0, 0, 0}}, 1.0f, 1), ContractViolation);
}

}  // namespace
}  // namespace phiz
