#include "stages/geometry/point_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "stages/geometry/error.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using Neighbours = std::vector<PointIndex::Neighbour>;

std::vector<std::pair<int, float>> pairs(const Neighbours& neighbours) {
  std::vector<std::pair<int, float>> result;
  for (const auto& n : neighbours) result.emplace_back(n.point_idx, n.squared_distance);
  return result;
}

/// All points, nearest first, ties by index.
Neighbours brute_force(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& query) {
  Neighbours all;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f d = query - points[i];
    all.push_back({static_cast<int>(i), (d.x() * d.x() + d.y() * d.y()) + d.z() * d.z()});
  }
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return std::tie(a.squared_distance, a.point_idx) < std::tie(b.squared_distance, b.point_idx);
  });
  return all;
}

void expect_agreement(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& query) {
  const PointIndex index(points);
  const Neighbours all = brute_force(points, query);
  Neighbours found;
  for (const int k : {1, 2, 7, 1000}) {
    index.find_nearest(query, k, found);
    const Neighbours expected(all.begin(), all.begin() + std::min<std::size_t>(k, all.size()));
    EXPECT_EQ(pairs(found), pairs(expected)) << "k = " << k;
  }
  for (const float radius : {0.0f, 0.5f, 1.0f, 2.5f}) {
    Neighbours expected;
    for (const auto& n : all)
      if (n.squared_distance <= radius * radius) expected.push_back(n);
    const auto nearest = index.find_nearest(query, radius);
    EXPECT_EQ(nearest.point_idx, expected.empty() ? -1 : expected[0].point_idx);
    std::sort(expected.begin(), expected.end(),
              [](const auto& a, const auto& b) { return a.point_idx < b.point_idx; });
    index.find_within(query, radius, found);
    EXPECT_EQ(pairs(found), pairs(expected)) << "radius = " << radius;
  }
}

TEST(PointIndex, AgreesWithBruteForceOnRandomPoints) {
  test::Random& random = test::random();
  for (int round = 0; round < 30; ++round) {
    std::vector<Eigen::Vector3f> points(1 + random.below(400));
    for (auto& p : points)
      p = Eigen::Vector3d(random.normal(), random.normal(), 0.1 * random.normal()).cast<float>();
    expect_agreement(points,
                     Eigen::Vector3d(random.normal(), random.normal(), random.normal()).cast<float>());
  }
}

TEST(PointIndex, GivesTiesToTheSmallerIndex) {
  // A lattice with each point three times, in shuffled order, asked at its points, edges and cells.
  test::Random& random = test::random();
  std::vector<Eigen::Vector3f> points;
  for (int copy = 0; copy < 3; ++copy)
    for (int i = 0; i < 125; ++i)
      points.emplace_back(static_cast<float>(i % 5), static_cast<float>(i / 5 % 5),
                          static_cast<float>(i / 25));
  for (std::size_t i = points.size() - 1; i > 0; --i) std::swap(points[i], points[random.below(i + 1)]);
  for (int round = 0; round < 20; ++round) {
    const auto half_step = [&] { return 0.5f * static_cast<float>(random.below(10)); };
    expect_agreement(points, {half_step(), half_step(), half_step()});
  }
  expect_agreement(std::vector<Eigen::Vector3f>(300, Eigen::Vector3f(1, 1, 1)), {1, 1.25f, 1});
}

TEST(PointIndex, FarFromTheOriginItStillAgrees) {
  test::Random& random = test::random();
  std::vector<Eigen::Vector3f> points(500);
  for (auto& p : points)
    p = Eigen::Vector3d(1e4 + random.uniform(), -3e4 + random.uniform(), 1e3 + random.uniform())
            .cast<float>();
  for (int round = 0; round < 20; ++round) expect_agreement(points, points[random.below(500)]);
}

TEST(PointIndex, NothingIsFoundInNothing) {
  const PointIndex index({});
  Neighbours found{{3, 1.0f}};
  index.find_nearest(Eigen::Vector3f::Zero(), 5, found);
  EXPECT_TRUE(found.empty());
  index.find_within(Eigen::Vector3f::Zero(), 5, found);
  EXPECT_TRUE(found.empty());
  EXPECT_EQ(index.find_nearest(Eigen::Vector3f::Zero(), 1e9f).point_idx, -1);
}

TEST(PointIndex, QueriesThatAreNotFiniteFindNothingAndPointsThatAreNotAreRefused) {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinity = std::numeric_limits<float>::infinity();
  const std::vector<Eigen::Vector3f> points{{0, 0, 0}, {1, 1, 1}};
  const PointIndex index(points);
  EXPECT_EQ(index.find_nearest({nan, 0, 0}, infinity).point_idx, -1);
  EXPECT_EQ(index.find_nearest({0, 0, 0.9f}, nan).point_idx, -1);
  EXPECT_EQ(index.find_nearest({0, 0, 0.9f}, infinity).point_idx, 0);
  EXPECT_THROW(PointIndex(std::vector<Eigen::Vector3f>{{0, infinity, 0}}), InvalidInput);
}

TEST(PointIndex, MayBeMoved) {
  PointIndex first(std::vector<Eigen::Vector3f>{{0, 0, 0}, {1, 1, 1}});
  const PointIndex second = std::move(first);
  EXPECT_EQ(second.find_nearest({0.9f, 1, 1}, 1.0f).point_idx, 1);
}

}  // namespace
}  // namespace phiz
