#include "stages/geometry/point_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "stages/geometry/error.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using test::random;

std::vector<Eigen::Vector3f> random_points(int count, float size) {
  std::vector<Eigen::Vector3f> points(count);
  for (auto& p : points)
    for (int axis = 0; axis < 3; ++axis) p[axis] = size * static_cast<float>(random().uniform(-1, 1));
  return points;
}

using Found = std::vector<std::pair<int, float>>;

Found brute_force(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& query, float radius) {
  Found found;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float d2 = (points[i] - query).squaredNorm();
    if (d2 <= radius * radius) found.emplace_back(static_cast<int>(i), d2);
  }
  return found;
}

Found in_grid(const PointGrid& grid, const Eigen::Vector3f& query, float radius) {
  Found found;
  grid.for_each_within(query, radius,
                       [&](int slot, float d2) { found.emplace_back(grid.order()[slot], d2); });
  std::sort(found.begin(), found.end());
  return found;
}

TEST(PointGrid, FindsWhatBruteForceFindsAtAnyRadius) {
  for (int round = 0; round < 12; ++round) {
    auto points = random_points(1 + static_cast<int>(random().below(500)), 2.0f);
    points.push_back(points[points.size() / 2]);  // one place twice
    const PointGrid grid(points, static_cast<float>(random().uniform(0.05, 3.0)));
    for (const float radius : {0.0f, 0.01f, 0.3f, 1.0f, 7.0f, 1e4f, 1e15f}) {
      for (int q = 0; q < 10; ++q) {
        const Eigen::Vector3f query =
            q < 3 ? points[q % points.size()] : random_points(1, q < 8 ? 2.5f : 40.0f)[0];
        ASSERT_EQ(in_grid(grid, query, radius), brute_force(points, query, radius)) << "radius " << radius;
      }
    }
  }
}

TEST(PointGrid, FindsPointsThatLieOnCellBordersAndOnTheSphere) {
  std::vector<Eigen::Vector3f> points;
  for (int z = 0; z < 5; ++z)
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 5; ++x) points.emplace_back(float(x), float(y), float(z));
  for (const float cell : {0.5f, 1.0f, 2.0f, 8.0f}) {
    const PointGrid grid(points, cell);
    for (const float radius : {0.0f, 1.0f, 2.0f, 3.0f})
      for (const auto& query : points)
        ASSERT_EQ(in_grid(grid, query, radius), brute_force(points, query, radius));
  }
}

TEST(PointGrid, EveryPointLiesInItsCellInTheCallersOrder) {
  const auto points = random_points(2000, 5.0f);
  const PointGrid grid(points, 1.0f);
  std::vector<int> seen(points.size(), 0);
  for (std::size_t c = 0; c < grid.cell_count(); ++c) {
    for (int slot = grid.cell_begin(c); slot < grid.cell_end(c); ++slot) {
      const int i = grid.order()[slot];
      ++seen[i];
      EXPECT_EQ(grid.sorted_points()[slot], points[i]);
      EXPECT_EQ(grid.cell_index(grid.coordinates(points[i])), c);
      if (slot > grid.cell_begin(c)) {
        EXPECT_LT(grid.order()[slot - 1], i);
      }
    }
  }
  EXPECT_EQ(seen, std::vector<int>(points.size(), 1));
}

TEST(PointGrid, VisitsComeInTheOrderOfSlots) {
  const auto points = random_points(500, 2.0f);
  const PointGrid grid(points, 0.4f);
  int last = -1;
  grid.for_each_within({0.1f, 0.2f, 0.3f}, 1.5f, [&](int slot, float) {
    EXPECT_GT(slot, last);
    last = slot;
  });
  EXPECT_GE(last, 0);
}

TEST(PointGrid, StaysWithinItsCellsWhenAPointIsFarAway) {
  auto points = random_points(300, 1.0f);
  points.emplace_back(1e6f, -1e6f, 1e6f);
  const PointGrid grid(points, 0.1f, 10'000);
  EXPECT_LE(grid.cell_count(), 10'000u);
  EXPECT_GT(grid.cell(), 0.1f);
  for (const float radius : {0.2f, 3.0f})
    EXPECT_EQ(in_grid(grid, points[5], radius), brute_force(points, points[5], radius));
}

TEST(PointGrid, OfNothingFindsNothing) {
  const PointGrid grid({}, 1.0f);
  EXPECT_EQ(grid.size(), 0u);
  EXPECT_EQ(grid.cell_count(), 0u);
  EXPECT_TRUE(in_grid(grid, Eigen::Vector3f::Zero(), 100.0f).empty());
}

TEST(PointGrid, RefusesNumbersThatAreNone) {
  std::vector<Eigen::Vector3f> points = random_points(10, 1.0f);
  EXPECT_THROW(PointGrid(points, 0.0f), ContractViolation);
  points[4].y() = std::numeric_limits<float>::infinity();
  EXPECT_THROW(PointGrid(points, 1.0f), ContractViolation);
  points[4].y() = 3e38f;
  points[5].y() = -3e38f;
  EXPECT_THROW(PointGrid(points, 1.0f), ContractViolation);
}

TEST(PointGrid, FindsThePointAtTheFarCornerWhateverTheCell) {
  for (int round = 0; round < 3000; ++round) {
    std::vector<Eigen::Vector3f> points = random_points(2, 3.0f);
    points.push_back(points[0].cwiseMax(points[1]));
    const PointGrid grid(points, static_cast<float>(random().uniform(0.1, 1.0)));
    ASSERT_EQ(in_grid(grid, points[2], 0.0f), brute_force(points, points[2], 0.0f));
  }
}

}  // namespace
}  // namespace phiz
