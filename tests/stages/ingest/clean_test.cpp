#include "stages/ingest/clean.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using Eigen::Vector3f;
using test::random;

float uniform(double low, double high) {
  return static_cast<float>(random().uniform(low, high));
}

std::vector<Vector3f> make_sphere(int count, float radius) {
  std::vector<Vector3f> points;
  for (int i = 0; i < count; ++i)
    points.push_back(
        radius *
        Eigen::Vector3d(random().normal(), random().normal(), random().normal()).normalized().cast<float>());
  return points;
}

TEST(KeepPoints, RowsStayTogetherAndInOrder) {
  PointCloud cloud;
  std::vector<char> keep;
  std::vector<int> expected;
  for (int i = 0; i < 100; ++i) {
    cloud.positions.emplace_back(float(i), 0.0f, 0.0f);
    cloud.normals.emplace_back(0.0f, float(i), 0.0f);
    cloud.colours.push_back({static_cast<std::uint8_t>(i), 1, 2});
    cloud.confidences.push_back(0.01f * float(i));
    keep.push_back(random().below(3) == 0);
    if (keep.back()) expected.push_back(i);
  }
  EXPECT_EQ(keep_points(cloud, keep), 100 - expected.size());
  ASSERT_EQ(cloud.size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    const int i = expected[k];
    EXPECT_EQ(cloud.positions[k].x(), float(i));
    EXPECT_EQ(cloud.normals[k].y(), float(i));
    EXPECT_EQ(cloud.colours[k][0], i);
    EXPECT_EQ(cloud.confidences[k], 0.01f * float(i));
  }
}

TEST(KeepPoints, AbsentAttributesStayAbsent) {
  PointCloud cloud;
  cloud.positions.resize(3, Vector3f::Zero());
  EXPECT_EQ(keep_points(cloud, {1, 0, 1}), 1u);
  EXPECT_FALSE(cloud.has_normals() || cloud.has_colours() || cloud.has_confidences());
  EXPECT_THROW(keep_points(cloud, {1}), ContractViolation);
}

TEST(FindSupported, KeepsADenseSurfaceAndDropsLonePointsAndSmallHeaps) {
  auto points = make_sphere(20'000, 80);  // four square millimetres a point
  const std::size_t surface = points.size();
  for (int i = 0; i < 40; ++i)
    points.emplace_back(uniform(-300, 300), uniform(-300, 300), 150.0f + 10 * float(i));
  const std::size_t lone = points.size();
  for (int i = 0; i < 20; ++i) points.emplace_back(200 + uniform(0, 3), uniform(0, 3), uniform(0, 3));
  const auto keep = find_supported(points, 6.0f);
  const auto kept = [&](std::size_t begin, std::size_t end) {
    return std::accumulate(keep.begin() + begin, keep.begin() + end, 0) / double(end - begin);
  };
  EXPECT_GT(kept(0, surface), 0.999);
  EXPECT_EQ(kept(surface, lone), 0);
  EXPECT_EQ(kept(lone, points.size()), 0);
}

TEST(FindSupported, SameAnswerAtAnyThreadCountAndForAnyOrder) {
  auto points = make_sphere(3000, 60);
  for (int i = 0; i < 30; ++i)
    points.emplace_back(uniform(-200, 200), uniform(-200, 200), uniform(-200, 200));
  std::vector<char> one, two;
  with_threads(1, [&] { one = find_supported(points, 7.0f); });
  with_threads(2, [&] { two = find_supported(points, 7.0f); });
  EXPECT_EQ(one, two);
  std::vector<Vector3f> backwards(points.rbegin(), points.rend());
  EXPECT_EQ(find_supported(backwards, 7.0f), std::vector<char>(one.rbegin(), one.rend()));
}

TEST(MedianSpacing, OfALatticeIsItsStep) {
  std::vector<Vector3f> points;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 60; ++x) points.emplace_back(0.5f * float(x), 0.5f * float(y), 0.0f);
  // The sixth neighbour on a square lattice lies across a diagonal.
  EXPECT_NEAR(median_spacing(points), 0.5f * std::sqrt(2.0f), 1e-5f);
}

TEST(MedianSpacing, ScalesWithTheUnit) {
  auto points = make_sphere(2000, 80);
  const float in_mm = median_spacing(points);
  for (auto& p : points) p *= 0.001f;
  EXPECT_NEAR(median_spacing(points) * 1000, in_mm, 1e-3f * in_mm);
}

}  // namespace
}  // namespace phiz
