#include "stages/template/self_intersection.h"

#include <gtest/gtest.h>

#include "stages/geometry/parallel.h"
#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

struct Soup {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Vector3i> triangles;
  void add(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    const int first = static_cast<int>(positions.size());
    positions.insert(positions.end(), {a, b, c});
    triangles.push_back({first, first + 1, first + 2});
  }
  Pairs crossings() const { return find_self_intersections(positions, triangles); }
};

TEST(SelfIntersection, FindsATriangleThatPiercesAnother) {
  Soup soup;
  soup.add({0, 0, 0}, {4, 0, 0}, {0, 4, 0});
  soup.add({1, 1, -1}, {1.5, 1, 1}, {1, 1.5, 1});
  soup.add({9, 9, -1}, {9.5, 9, 1}, {9, 9.5, 1});
  EXPECT_EQ(soup.crossings(), (Pairs{{0, 1}}));
}

TEST(SelfIntersection, TouchingIsNoCrossing) {
  Soup soup;
  soup.add({0, 0, 0}, {4, 0, 0}, {0, 4, 0});
  soup.add({1, 1, 0}, {1.5, 1, 1}, {1, 1.5, 1});
  EXPECT_TRUE(soup.crossings().empty());
}

TEST(SelfIntersection, MeshesOfTheZooCrossNowhere) {
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    std::vector<Eigen::Vector3d> positions;
    for (const auto& p : mesh.positions) positions.push_back(p.cast<double>());
    EXPECT_TRUE(find_self_intersections(positions, mesh.triangles).empty()) << name;
  }
}

TEST(SelfIntersection, DoesNotDependOnTheOrderOfTrianglesNorOnThreads) {
  Soup soup;
  test::Random& dice = test::random();
  const auto point = [&] { return Eigen::Vector3d(dice.uniform(), dice.uniform(), dice.uniform()); };
  for (int k = 0; k < 300; ++k) {
    const Eigen::Vector3d p = point();
    soup.add(p, p + 0.2 * point(), p + 0.2 * point());
  }
  const Pairs expected = soup.crossings();
  EXPECT_FALSE(expected.empty());
  for (const int threads : {1, 2}) with_threads(threads, [&] { EXPECT_EQ(soup.crossings(), expected); });
  Soup reversed = soup;
  std::reverse(reversed.triangles.begin(), reversed.triangles.end());
  Pairs back;
  for (const auto& [a, b] : reversed.crossings()) back.emplace_back(299 - b, 299 - a);
  std::sort(back.begin(), back.end());
  EXPECT_EQ(back, expected);
}

}  // namespace
}  // namespace phiz
