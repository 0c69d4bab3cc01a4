#include "stages/geometry/surface_index.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "stages/geometry/error.h"
#include "stages/geometry/morton.h"
#include "stages/geometry/parallel.h"
#include "stages/geometry/triangle_distance.h"
#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Nearest {
  int triangle_idx = -1;
  double squared_distance = kInfinity;
};

Nearest brute_force(const TriangleMesh& mesh, const Eigen::Vector3d& query) {
  Nearest best;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    const Eigen::Vector3i& v = mesh.triangles[t];
    const double squared =
        find_nearest_on_triangle(query, mesh.positions[v[0]].cast<double>(),
                                 mesh.positions[v[1]].cast<double>(), mesh.positions[v[2]].cast<double>())
            .squared_distance;
    if (squared < best.squared_distance) best = {static_cast<int>(t), squared};
  }
  return best;
}

/// Distance by exhausting a fine barycentric grid: slow, inexact, but it cannot share a mistake with the
/// product.
double sampled_distance(const Eigen::Vector3d& query, const Eigen::Matrix3d& corners) {
  constexpr int kSteps = 200;
  double best = kInfinity;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; i + j <= kSteps; ++j) {
      const Eigen::Vector3d weights(1.0 - double(i + j) / kSteps, double(i) / kSteps, double(j) / kSteps);
      best = std::min(best, (corners * weights - query).norm());
    }
  return best;
}

Eigen::Vector3d random_vector(test::Random& random, double scale) {
  return scale * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
}

TriangleMesh random_soup(test::Random& random, int triangle_count) {
  TriangleMesh mesh;
  for (int t = 0; t < triangle_count; ++t) {
    const Eigen::Vector3d centre = random_vector(random, 2.0);
    for (int i = 0; i < 3; ++i) mesh.positions.push_back((centre + random_vector(random, 0.3)).cast<float>());
    mesh.triangles.emplace_back(3 * t, 3 * t + 1, 3 * t + 2);
  }
  return mesh;
}

void expect_agreement(const TriangleMesh& mesh, const SurfaceIndex& index, const Eigen::Vector3d& query) {
  const Nearest expected = brute_force(mesh, query);
  const auto hit = index.find_nearest(query, kInfinity);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->triangle_idx, expected.triangle_idx);
  EXPECT_EQ(hit->distance, std::sqrt(expected.squared_distance));
  EXPECT_NEAR(hit->weights.sum(), 1, 1e-15);
  EXPECT_GE(hit->weights.minCoeff(), -1e-12);
  EXPECT_NEAR((hit->position - query).norm(), hit->distance, 1e-12);
  const Eigen::Vector3i& t = mesh.triangles[hit->triangle_idx];
  Eigen::Vector3d from_weights = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i) from_weights += hit->weights[i] * mesh.positions[t[i]].cast<double>();
  EXPECT_LT((from_weights - hit->position).norm(), 1e-12);
}

TEST(SurfaceIndex, AgreesWithBruteForceOnTheMeshZoo) {
  test::Random& random = test::random();
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    SCOPED_TRACE(name);
    const SurfaceIndex index(mesh.positions, mesh.triangles);
    for (int i = 0; i < 200; ++i) expect_agreement(mesh, index, random_vector(random, i % 2 ? 1.0 : 30.0));
    for (const Eigen::Vector3f& p : mesh.positions) {  // on vertices every distance is a tie
      expect_agreement(mesh, index, p.cast<double>());
      expect_agreement(mesh, index, 1.5 * p.cast<double>());
    }
  }
}

TEST(SurfaceIndex, AgreesWithBruteForceOnSoupsAndShiftedSoups) {
  test::Random& random = test::random();
  for (int round = 0; round < 10; ++round) {
    TriangleMesh mesh = random_soup(random, 1 + static_cast<int>(random.below(300)));
    const Eigen::Vector3f shift = random_vector(random, round < 5 ? 0.0 : 1000.0).cast<float>();
    for (Eigen::Vector3f& p : mesh.positions) p += shift;
    const SurfaceIndex index(mesh.positions, mesh.triangles);
    for (int i = 0; i < 100; ++i)
      expect_agreement(mesh, index, shift.cast<double>() + random_vector(random, 3.0));
  }
}

TEST(SurfaceIndex, DistanceToATriangleIsTheDistanceToItsPoints) {
  test::Random& random = test::random();
  for (int i = 0; i < 60; ++i) {
    Eigen::Matrix3d corners;
    for (int k = 0; k < 3; ++k) corners.col(k) = random_vector(random, 1.0);
    if (i % 3 == 1) corners.col(2) = 0.7 * corners.col(0) + 0.3 * corners.col(1);  // a segment
    if (i % 30 == 2) corners.col(2) = corners.col(1) = corners.col(0);             // a point
    const Eigen::Vector3d query = random_vector(random, 2.0);
    const double sampled = sampled_distance(query, corners);
    const double exact = std::sqrt(
        find_nearest_on_triangle(query, corners.col(0), corners.col(1), corners.col(2)).squared_distance);
    EXPECT_LE(exact, sampled + 1e-12);
    EXPECT_NEAR(exact, sampled, 0.02);
  }
}

TEST(SurfaceIndex, SliversAreMeasuredAccurately) {
  test::Random& random = test::random();
  for (int i = 0; i < 2000; ++i) {
    // A thin triangle on the x axis: the nearest point is known up to its height.
    const double height = std::pow(10.0, random.uniform(-14, -3));
    const Eigen::Vector3d a(0, 0, 0), b(10, 0, 0), c(random.uniform(0, 10), height, 0);
    const Eigen::Vector3d query = random_vector(random, 20.0);
    const double along = std::clamp(query.x(), 0.0, 10.0);
    const double expected = (query - Eigen::Vector3d(along, 0, 0)).norm();
    EXPECT_NEAR(std::sqrt(find_nearest_on_triangle(query, a, b, c).squared_distance), expected,
                1e-9 + 1.01 * height);
  }
}

TEST(SurfaceIndex, BatchGivesTheBitsOfSingleQueriesAtAnyThreadCount) {
  test::Random& random = test::random();
  const TriangleMesh mesh = test::icosphere(4);
  const SurfaceIndex index(mesh.positions, mesh.triangles);
  std::vector<Eigen::Vector3f> queries(6000);
  for (auto& q : queries) q = random_vector(random, 0.7).cast<float>();
  queries[17].x() = std::numeric_limits<float>::quiet_NaN();
  std::vector<SurfaceHit> one, two;
  with_threads(1, [&] { one = index.find_nearest(queries, 0.6); });
  with_threads(2, [&] { two = index.find_nearest(queries, 0.6); });
  ASSERT_EQ(one.size(), queries.size());
  int misses = 0;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const SurfaceHit single = index.find_nearest(queries[i].cast<double>(), 0.6).value_or(SurfaceHit{});
    for (const SurfaceHit& hit : {one[i], two[i]}) {
      EXPECT_EQ(hit.triangle_idx, single.triangle_idx);
      EXPECT_EQ(hit.weights, single.weights);
      EXPECT_EQ(hit.position, single.position);
      EXPECT_EQ(hit.distance, single.distance);
    }
    misses += single.triangle_idx < 0;
  }
  EXPECT_EQ(one[17].triangle_idx, -1);
  EXPECT_GT(misses, 0);
  EXPECT_LT(misses, 6000);
}

TEST(SurfaceIndex, MaximalDistanceIsInclusive) {
  const TriangleMesh mesh = test::single_triangle();
  const SurfaceIndex index(mesh.positions, mesh.triangles);
  EXPECT_TRUE(index.find_nearest({0.25, 0.25, 0.5}, 0.5));
  EXPECT_FALSE(index.find_nearest({0.25, 0.25, 0.5}, 0.4999));
  EXPECT_TRUE(index.find_nearest({0.25, 0.25, 0}, 0));
  EXPECT_FALSE(index.find_nearest({0.25, 0.25, 0.5}, -1));
}

TEST(SurfaceIndex, FirstHitsAgreeWithTheSphere) {
  test::Random& random = test::random();
  const TriangleMesh mesh = test::icosphere(4);
  const SurfaceIndex index(mesh.positions, mesh.triangles);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d direction = random_vector(random, 1.0);
    const auto inside = index.find_first_hit(Eigen::Vector3d(0.05, 0.1, -0.02), direction, 0, kInfinity);
    ASSERT_TRUE(inside);  // no ray slips out
    EXPECT_NEAR(inside->position.norm(), 1, 2e-3);
    const Eigen::Vector3d start = -5 * direction.normalized();
    const auto outside = index.find_first_hit(start, direction.normalized(), 0, kInfinity);
    ASSERT_TRUE(outside);
    EXPECT_NEAR(outside->distance, 4, 2e-3);
    EXPECT_LT((start + outside->distance * direction.normalized() - outside->position).norm(), 1e-12);
  }
  // Along the axes, through vertices and edges.
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_TRUE(index.find_first_hit(Eigen::Vector3d::Zero(), Eigen::Vector3d::Unit(axis), 0, kInfinity));
}

TEST(SurfaceIndex, FirstHitIsTheSmallestOfAllHits) {
  test::Random& random = test::random();
  const TriangleMesh mesh = random_soup(random, 400);
  const SurfaceIndex index(mesh.positions, mesh.triangles);
  std::vector<SurfaceIndex> singles;
  for (const Eigen::Vector3i& t : mesh.triangles)
    singles.emplace_back(mesh.positions, std::vector<Eigen::Vector3i>{t});
  int hits = 0;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d origin = random_vector(random, 4.0), direction = random_vector(random, 1.0);
    double nearest = kInfinity;
    int triangle_idx = -1;
    for (std::size_t t = 0; t < singles.size(); ++t)
      if (const auto hit = singles[t].find_first_hit(origin, direction, 0.1, 5);
          hit && hit->distance < nearest)
        nearest = hit->distance, triangle_idx = static_cast<int>(t);
    const auto hit = index.find_first_hit(origin, direction, 0.1, 5);
    EXPECT_EQ(hit ? hit->triangle_idx : -1, triangle_idx);
    EXPECT_EQ(hit ? hit->distance : kInfinity, nearest);
    hits += hit.has_value();
  }
  EXPECT_GT(hits, 20);
}

TEST(SurfaceIndex, EmptySurfacesAndBadInputAreAnswered) {
  const SurfaceIndex empty({}, {});
  EXPECT_FALSE(empty.find_nearest(Eigen::Vector3d::Zero(), kInfinity));
  EXPECT_FALSE(empty.find_first_hit(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(), 0, kInfinity));
  const std::vector<Eigen::Vector3f> positions{
      {0, 0, 0}, {1, 0, 0}, {0, std::numeric_limits<float>::infinity(), 0}};
  EXPECT_THROW(SurfaceIndex(positions, std::vector<Eigen::Vector3i>{{0, 1, 3}}), InvalidInput);
  EXPECT_THROW(SurfaceIndex(positions, std::vector<Eigen::Vector3i>{{0, 1, -1}}), InvalidInput);
  EXPECT_THROW(SurfaceIndex(positions, std::vector<Eigen::Vector3i>{{0, 1, 2}}), InvalidInput);
  const TriangleMesh mesh = test::single_triangle();
  const SurfaceIndex index(mesh.positions, mesh.triangles);
  EXPECT_FALSE(index.find_nearest({0, std::nan(""), 0}, kInfinity));
  EXPECT_FALSE(index.find_first_hit({0, 0, 1}, {0, 0, std::nan("")}, 0, kInfinity));
}

TEST(SurfaceIndex, ManyEqualOrNestedTrianglesDoNotOverflow) {
  TriangleMesh mesh;
  for (int i = 0; i < 3000; ++i) {  // sizes from 1 down to the smallest float, all at one corner
    const float size = std::pow(0.97f, static_cast<float>(i));
    mesh.positions.insert(mesh.positions.end(), {{0, 0, 0}, {size, 0, 0}, {0, size, 0}});
    mesh.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
  }
  const SurfaceIndex index(mesh.positions, mesh.triangles);
  expect_agreement(mesh, index, {0, 0, 1});
  expect_agreement(mesh, index, {0.3, 0.3, -1});
  expect_agreement(mesh, index, {2, 2, 0});
}

TEST(SurfaceIndex, MortonOrderIsAPermutationThatKeepsNeighboursTogether) {
  test::Random& random = test::random();
  std::vector<Eigen::Vector3f> points(4096);
  for (auto& p : points)
    p = Eigen::Vector3d(random.uniform(), random.uniform(), random.uniform()).cast<float>();
  points[5].setConstant(std::numeric_limits<float>::infinity());
  const std::vector<int> order = morton_order(points);
  std::vector<int> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  for (int i = 0; i < 4096; ++i) EXPECT_EQ(sorted[i], i);
  double step = 0;
  for (int i = 2; i < 4096; ++i) step += (points[order[i]] - points[order[i - 1]]).norm() / 4094;
  EXPECT_LT(step, 0.15);  // two random points are 0.66 apart
}

}  // namespace
}  // namespace phiz
