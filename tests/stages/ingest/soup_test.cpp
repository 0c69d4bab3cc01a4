#include "stages/ingest/soup.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "stages/geometry/error.h"
#include "stages/geometry/surface_index.h"
#include "tests/support/mesh_zoo.h"

namespace phiz {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

ScanFile scan_of(const TriangleMesh& mesh) {
  ScanFile scan;
  scan.points.positions = mesh.positions;
  scan.triangles = mesh.triangles;
  return scan;
}

double area_of(const ScanFile& scan, int t) {
  const auto& p = scan.points.positions;
  const Eigen::Vector3i& c = scan.triangles[t];
  return 0.5 * double((p[c[1]] - p[c[0]]).cross(p[c[2]] - p[c[0]]).norm());
}

TEST(SampleSoup, LiesOnTheTrianglesInProportionToTheirArea) {
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    const ScanFile scan = scan_of(mesh);
    constexpr int kSamples = 4000;
    const PointCloud cloud = sample_soup(scan, kSamples);
    ASSERT_EQ(cloud.size(), std::size_t(kSamples)) << name;
    double total = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) total += area_of(scan, int(t));
    const SurfaceIndex index(mesh.positions, mesh.triangles);
    for (const auto& p : cloud.positions) {
      const auto hit = index.find_nearest(p.cast<double>(), 1.0);
      ASSERT_TRUE(hit.has_value()) << name;
      ASSERT_LT(hit->distance, 1e-6) << name;
    }
    // Samples come triangle by triangle: each gets its share to within one.
    double begin = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const double end = begin + area_of(scan, int(t)) / total * kSamples;
      for (int i = int(std::ceil(begin + 0.5)); i + 1.5 < end; ++i) {
        TriangleMesh one = mesh;
        one.triangles = {mesh.triangles[t]};
        const auto hit =
            SurfaceIndex(one.positions, one.triangles).find_nearest(cloud.positions[i].cast<double>(), 1.0);
        ASSERT_TRUE(hit && hit->distance < 1e-6) << name << " triangle " << t;
        i += 40;  // some of each
      }
      begin = end;
    }
  }
}

TEST(SampleSoup, SpreadsEvenlyWithinATriangle) {
  const PointCloud cloud = sample_soup(scan_of(test::single_triangle()), 4000);
  const auto& corners = test::single_triangle().positions;
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  for (const auto& p : cloud.positions) mean += p / 4000.0f;
  const Eigen::Vector3f centroid = (corners[0] + corners[1] + corners[2]) / 3.0f;
  EXPECT_LT((mean - centroid).norm(), 0.01f);
}

TEST(SampleSoup, LeavesOutTrianglesWithoutAreaOrNumbers) {
  TriangleMesh mesh = test::single_triangle();
  const int n = int(mesh.positions.size());
  mesh.positions.emplace_back(kNan, 0.0f, 0.0f);
  mesh.positions.emplace_back(std::numeric_limits<float>::infinity(), 0.0f, 0.0f);
  mesh.triangles.insert(mesh.triangles.begin(), {{0, 0, 1}, {0, 1, n}, {0, 1, n + 1}});
  mesh.triangles.push_back({0, 2, n});
  mesh.triangles.push_back({1, 1, 1});
  const PointCloud cloud = sample_soup(scan_of(mesh), 500);
  const PointCloud plain = sample_soup(scan_of(test::single_triangle()), 500);
  EXPECT_EQ(cloud.positions, plain.positions);
}

TEST(SampleSoup, InterpolatesColours) {
  ScanFile scan = scan_of(test::single_triangle());
  scan.points.colours = {{0, 0, 0}, {200, 0, 100}, {0, 200, 100}};
  const PointCloud cloud = sample_soup(scan, 300);
  ASSERT_EQ(cloud.colours.size(), 300u);
  const auto& p = scan.points.positions;
  for (std::size_t i = 0; i < 300; ++i) {
    const Eigen::Vector3f d = cloud.positions[i] - p[0], u = p[1] - p[0], v = p[2] - p[0];
    const float w1 = d.dot(u) / u.squaredNorm(), w2 = d.dot(v) / v.squaredNorm();  // a right angle at 0
    EXPECT_NEAR(float(cloud.colours[i][0]), 200 * w1, 1.0f);
    EXPECT_NEAR(float(cloud.colours[i][1]), 200 * w2, 1.0f);
    EXPECT_NEAR(float(cloud.colours[i][2]), 100 * (w1 + w2), 1.0f);
  }
}

TEST(SampleSoup, RefusesASoupWithoutArea) {
  TriangleMesh mesh = test::single_triangle();
  mesh.triangles = {{0, 0, 0}, {0, 1, 1}};
  EXPECT_THROW(sample_soup(scan_of(mesh), 100), InvalidInput);
  mesh = test::single_triangle();
  for (auto& p : mesh.positions) p.x() = kNan;
  EXPECT_THROW(sample_soup(scan_of(mesh), 100), InvalidInput);
}

}  // namespace
}  // namespace phiz
