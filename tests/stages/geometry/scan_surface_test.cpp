#include "stages/geometry/scan_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using Eigen::Vector3f;
using test::random;

void add(PointCloud& cloud, const Vector3f& p, const Vector3f& n) {
  cloud.positions.push_back(p);
  cloud.normals.push_back(n);
  cloud.confidences.push_back(1);
}

/// A square of 2 * half mm a side at height z, one point a square millimetre, jittered in the plane.
void add_sheet(PointCloud& cloud, float half, float z, float up, float hole_radius = 0) {
  for (float y = -half; y <= half; y += 1)
    for (float x = -half; x <= half; x += 1) {
      const Vector3f p(x + static_cast<float>(random().uniform(-0.4, 0.4)),
                       y + static_cast<float>(random().uniform(-0.4, 0.4)), z);
      if (p.head<2>().norm() >= hole_radius) add(cloud, p, {0, 0, up});
    }
}

/// About one point a square millimetre of a sphere about the origin, evenly spread.
PointCloud make_sphere(float radius, int count, double noise_mm = 0) {
  PointCloud cloud;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double y = 1 - 2 * (i + 0.5) / count, r = std::sqrt(1 - y * y);
    const Vector3f n = Eigen::Vector3d(r * std::cos(golden * i), y, r * std::sin(golden * i)).cast<float>();
    add(cloud, (radius + static_cast<float>(noise_mm * random().normal())) * n, n);
  }
  return cloud;
}

Vector3f random_direction() {
  return Eigen::Vector3d(random().normal(), random().normal(), random().normal()).normalized().cast<float>();
}

TEST(ScanSurface, MeasuresTheOffsetToAPlane) {
  PointCloud cloud;
  add_sheet(cloud, 30, 2.0f, 1);
  const ScanSurface scan(cloud);
  for (int i = 0; i < 200; ++i) {
    const float h = static_cast<float>(random().uniform(-4, 4));
    const Vector3f p(static_cast<float>(random().uniform(-20, 20)),
                     static_cast<float>(random().uniform(-20, 20)), 2.0f + h);
    const auto m = scan.measure(p, Vector3f::UnitZ(), 2.5f, 6.0f);
    ASSERT_GT(m.confidence, 0.3f);
    ASSERT_NEAR(m.offset_mm, -h, 1e-3f);
    ASSERT_NEAR(m.normal.z(), 1.0f, 1e-5f);
    const Vector3f slanted = Vector3f(0.4f, -0.2f, 1).normalized();
    const auto s = scan.measure(p, slanted, 2.5f, 8.0f);
    ASSERT_GT(s.confidence, 0.3f);
    ASSERT_NEAR(s.offset_mm, -h / slanted.z(), 0.02f);
  }
}

TEST(ScanSurface, CurvatureDoesNotBiasTheMeasure) {
  // A mean of heights alone would be off by bandwidth^2 / (4 R), the planes alone by as much the other way.
  for (const float radius : {12.0f, 40.0f}) {
    const ScanSurface scan(make_sphere(radius, static_cast<int>(12.6f * radius * radius)));
    double sum = 0, sum_squares = 0;
    constexpr int kReads = 300;
    for (int i = 0; i < kReads; ++i) {
      const Vector3f n = random_direction();
      const float h = static_cast<float>(random().uniform(-1.5, 1.5));
      const auto m = scan.measure((radius + h) * n, n, 2.0f, 5.0f);
      ASSERT_GT(m.confidence, 0.3f);
      const double error = m.offset_mm + h;
      ASSERT_LT(std::abs(error), 0.05);
      sum += error;
      sum_squares += error * error;
      EXPECT_GT(m.normal.dot(n), 0.999f);
    }
    EXPECT_LT(std::abs(sum / kReads), 0.015) << radius;
    EXPECT_LT(std::sqrt(sum_squares / kReads), 0.02) << radius;
  }
}

TEST(ScanSurface, AveragesNoiseAway) {
  const ScanSurface scan(make_sphere(40, 20'000, 0.2));
  double sum_squares = 0;
  for (int i = 0; i < 300; ++i) {
    const Vector3f n = random_direction();
    const auto m = scan.measure(40.5f * n, n, 2.0f, 5.0f);
    sum_squares += std::pow(m.offset_mm + 0.5f, 2);
  }
  EXPECT_LT(std::sqrt(sum_squares / 300), 0.1);  // half of the noise of a point, and less
}

TEST(ScanSurface, MeasuresNothingInAHole) {
  PointCloud cloud;
  add_sheet(cloud, 40, 0, 1, 20);
  const ScanSurface scan(cloud);
  EXPECT_EQ(scan.measure({0, 0, 1}, Vector3f::UnitZ(), 2.0f, 5.0f).confidence, 0);
  EXPECT_EQ(scan.measure({8, 0, 1}, Vector3f::UnitZ(), 2.0f, 5.0f).confidence, 0);
  EXPECT_GT(scan.measure({30, 0, 1}, Vector3f::UnitZ(), 2.0f, 5.0f).confidence, 0.3f);
  EXPECT_EQ(scan.measure({200, 0, 0}, Vector3f::UnitZ(), 2.0f, 5.0f).confidence, 0);
}

TEST(ScanSurface, DoesNotReachBeyondItsReach) {
  PointCloud cloud;
  add_sheet(cloud, 30, 0, 1);
  const ScanSurface scan(cloud);
  EXPECT_EQ(scan.measure({0, 0, 12}, Vector3f::UnitZ(), 2.0f, 5.0f).confidence, 0);
}

TEST(ScanSurface, DoesNotJumpBetweenTheFacesOfASheet) {
  PointCloud cloud;  // an ear: two faces 3 mm apart that look away from each other
  add_sheet(cloud, 25, 0, 1);
  add_sheet(cloud, 25, -3, -1);
  const ScanSurface scan(cloud);
  for (const float h : {-2.5f, -1.5f, 0.0f, 1.0f, 2.0f}) {
    const auto front = scan.measure({1.3f, -2.1f, h}, Vector3f::UnitZ(), 2.0f, 6.0f);
    ASSERT_GT(front.confidence, 0);
    EXPECT_NEAR(front.offset_mm, -h, 1e-3f);
    const auto back = scan.measure({1.3f, -2.1f, -3 - h}, -Vector3f::UnitZ(), 2.0f, 6.0f);
    ASSERT_GT(back.confidence, 0);
    EXPECT_NEAR(back.offset_mm, -h, 1e-3f);
  }
}

TEST(ScanSurface, MatchesAreTheBestOfThoseThatFaceTheSameWay) {
  PointCloud cloud;
  add_sheet(cloud, 25, 0, 1);
  add_sheet(cloud, 25, -3, -1);
  const ScanSurface scan(cloud);
  for (int i = 0; i < 200; ++i) {
    const Vector3f p(static_cast<float>(random().uniform(-20, 20)),
                     static_cast<float>(random().uniform(-20, 20)),
                     static_cast<float>(random().uniform(-4, 1)));
    for (const float up : {1.0f, -1.0f}) {
      const auto match = scan.find_match(p, {0, 0, up}, 10, 20);
      ASSERT_GE(match.surfel_idx, 0);
      const Surfel& s = scan.surfels()[match.surfel_idx];
      EXPECT_NEAR(s.normal.z(), up, 1e-5f);
      EXPECT_NEAR(match.distance, (s.position - p).norm(), 1e-4f);
    }
  }
}

TEST(ScanSurface, MatchesRefuseOppositeNormalsAndWhatIsTooFar) {
  PointCloud cloud;
  add_sheet(cloud, 25, 0, 1);
  const ScanSurface scan(cloud);
  EXPECT_EQ(scan.find_match({0, 0, 1}, -Vector3f::UnitZ(), 10, 20).surfel_idx, -1);
  EXPECT_EQ(scan.find_match({0, 0, 1}, Vector3f::UnitX(), 10, 20).surfel_idx, -1);
  EXPECT_EQ(scan.find_match({0, 0, 9}, Vector3f::UnitZ(), 10, 8).surfel_idx, -1);
  EXPECT_GE(scan.find_match({0, 0, 7}, Vector3f::UnitZ(), 10, 8).surfel_idx, 0);
}

TEST(ScanSurface, SurfelsLieOnTheSurfaceAndKnowTheRim) {
  PointCloud cloud;
  add_sheet(cloud, 25, 0, 1);
  const ScanSurface scan(cloud);
  ASSERT_GT(scan.surfels().size(), 200u);
  double inside = 0, rim = 0;
  int inside_count = 0, rim_count = 0;
  for (const Surfel& s : scan.surfels()) {
    EXPECT_NEAR(s.position.z(), 0, 1e-5f);
    const float out = s.position.head<2>().cwiseAbs().maxCoeff();
    if (out < 20) inside += s.border, ++inside_count;
    if (out > 24.5f) rim += s.border, ++rim_count;
  }
  EXPECT_LT(inside / inside_count, 0.35);
  EXPECT_GT(rim / rim_count, 0.5);
}

TEST(ScanSurface, SameSurfelsAtAnyThreadCount) {
  const PointCloud cloud = make_sphere(40, 15'000, 0.1);
  std::vector<Surfel> one, two;
  with_threads(1, [&] { one = ScanSurface(cloud).surfels(); });
  with_threads(2, [&] { two = ScanSurface(cloud).surfels(); });
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].position, two[i].position);
    EXPECT_EQ(one[i].normal, two[i].normal);
    EXPECT_EQ(one[i].border, two[i].border);
  }
}

TEST(ScanSurface, NeedsNormals) {
  PointCloud cloud;
  cloud.positions.resize(10, Vector3f::Zero());
  EXPECT_THROW(ScanSurface{cloud}, InvalidInput);
  EXPECT_THROW(ScanSurface{PointCloud{}}, InvalidInput);
}

}  // namespace
}  // namespace phiz
