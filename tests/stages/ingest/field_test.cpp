#include "stages/ingest/field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

PointCloud make_sphere(int count, float radius) {
  PointCloud cloud;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double y = 1 - 2 * (i + 0.5) / count, r = std::sqrt(1 - y * y);
    cloud.normals.push_back(
        Eigen::Vector3d(r * std::cos(golden * i), y, r * std::sin(golden * i)).cast<float>());
    cloud.positions.push_back(radius * cloud.normals.back());
    cloud.confidences.push_back(0.8f);
  }
  return cloud;
}

TEST(DistanceFieldOfCloud, IsTheSignedDistanceToASphere) {
  constexpr double kRadius = 40, kVoxel = 2;
  const DistanceField field = compute_distance_field(make_sphere(20'000, kRadius), kVoxel);
  ASSERT_EQ(field.voxel_mm, kVoxel);
  ASSERT_GT(field.coordinates.size(), 5000u);
  for (std::size_t i = 0; i < field.coordinates.size(); ++i) {
    const Eigen::Vector3d p = field.origin_mm + field.voxel_mm * field.coordinates[i].cast<double>();
    const double truth = p.norm() - kRadius;
    if (std::abs(truth) > field.truncation_mm - kVoxel) continue;
    ASSERT_NEAR(field.distances_mm[i], truth, 0.4) << p.transpose();
    if (std::abs(truth) < 0.5) {
      ASSERT_NEAR(field.distances_mm[i], truth, 0.1) << p.transpose();
    }
  }
}

TEST(DistanceFieldOfCloud, HoldsThePromisesOfItsNoun) {
  const DistanceField field = compute_distance_field(make_sphere(5000, 30), 2.0);
  for (std::size_t i = 0; i < field.coordinates.size(); ++i) {
    ASSERT_LE(std::abs(field.distances_mm[i]), field.truncation_mm);
    ASSERT_GT(field.confidences[i], 0);
    ASSERT_LE(field.confidences[i], 0.8f);
    if (i == 0) continue;
    const auto &a = field.coordinates[i - 1], &b = field.coordinates[i];
    ASSERT_LT(std::tuple(a.x(), a.y(), a.z()), std::tuple(b.x(), b.y(), b.z()));
  }
}

TEST(DistanceFieldOfCloud, CoversTheBandAboutEveryPoint) {
  const PointCloud cloud = make_sphere(5000, 30);
  const DistanceField field = compute_distance_field(cloud, 2.0);
  std::vector<std::tuple<int, int, int>> places;
  for (const auto& c : field.coordinates) places.emplace_back(c.x(), c.y(), c.z());
  for (const auto& p : cloud.positions) {
    const Eigen::Vector3i c =
        ((p.cast<double>() - field.origin_mm) / field.voxel_mm).array().round().cast<int>();
    ASSERT_TRUE(std::binary_search(places.begin(), places.end(), std::tuple(c.x(), c.y(), c.z())));
  }
}

TEST(DistanceFieldOfCloud, ConfidenceFallsWithTheDistance) {
  const DistanceField field = compute_distance_field(make_sphere(20'000, 40), 2.0);
  double near = 0, far = 0;
  int near_count = 0, far_count = 0;
  for (std::size_t i = 0; i < field.coordinates.size(); ++i) {
    if (std::abs(field.distances_mm[i]) < 1) near += field.confidences[i], ++near_count;
    if (std::abs(field.distances_mm[i]) > 4) far += field.confidences[i], ++far_count;
  }
  EXPECT_GT(near / near_count, 2 * far / far_count);
}

TEST(DistanceFieldOfCloud, SameBitsAtAnyThreadCount) {
  const PointCloud cloud = make_sphere(5000, 30);
  DistanceField one, two;
  with_threads(1, [&] { one = compute_distance_field(cloud, 2.0); });
  with_threads(2, [&] { two = compute_distance_field(cloud, 2.0); });
  EXPECT_EQ(one.coordinates, two.coordinates);
  EXPECT_EQ(one.distances_mm, two.distances_mm);
  EXPECT_EQ(one.confidences, two.confidences);
}

TEST(DistanceFieldOfCloud, NeedsAnOrientedCloud) {
  PointCloud cloud = make_sphere(100, 30);
  EXPECT_THROW(compute_distance_field(cloud, 0), ContractViolation);
  cloud.normals.clear();
  EXPECT_THROW(compute_distance_field(cloud, 2.0), ContractViolation);
}

}  // namespace
}  // namespace phiz
