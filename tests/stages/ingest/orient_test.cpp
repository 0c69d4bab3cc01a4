#include "stages/ingest/orient.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "stages/geometry/parallel.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using Eigen::Vector3f;
using test::random;

/// Evenly spread directions.
std::vector<Vector3f> directions(int count) {
  std::vector<Vector3f> result;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double y = 1 - 2 * (i + 0.5) / count, r = std::sqrt(1 - y * y);
    result.push_back(Eigen::Vector3d(r * std::cos(golden * i), y, r * std::sin(golden * i)).cast<float>());
  }
  return result;
}

/// A guide too far away to say anything.
OrientationGuide no_guide() {
  return {{Vector3f(5000, 0, 0), Vector3f(5000, 9, 0)}, {Vector3f::UnitX(), Vector3f::UnitX()}};
}

PointCloud make_sphere(int count, float radius, double noise_mm) {
  PointCloud cloud;
  for (const auto& n : directions(count))
    cloud.positions.push_back((radius + static_cast<float>(noise_mm * random().normal())) * n);
  return cloud;
}

TEST(EstimateNormals, OfASpherePointOutwardWithinADegree) {
  PointCloud cloud = make_sphere(25'000, 80, 0);
  const NormalEstimate estimate = estimate_normals(cloud, 4.0f, no_guide());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float along = cloud.normals[i].dot(cloud.positions[i].normalized());
    ASSERT_GT(along, std::cos(1.0f * std::numbers::pi_v<float> / 180)) << i;
    ASSERT_NEAR(cloud.normals[i].norm(), 1, 1e-5f);
    ASSERT_GT(cloud.confidences[i], 0.9f);
    ASSERT_LE(cloud.confidences[i], 1.0f);
  }
  EXPECT_NEAR(estimate.density_per_mm2, 25'000 / (4 * std::numbers::pi * 80 * 80), 0.08);
  EXPECT_LT(estimate.noise_mm, 0.06);  // what the sphere curves within the radius
}

TEST(EstimateNormals, ConfidenceFallsAndNoiseRisesWithTheScatter) {
  double last_confidence = 2, last_noise = -1;
  for (const double noise : {0.0, 0.2, 0.6}) {
    PointCloud cloud = make_sphere(12'000, 80, noise);
    const NormalEstimate estimate = estimate_normals(cloud, 5.0f, no_guide());
    double confidence = 0;
    for (const float c : cloud.confidences) confidence += c / double(cloud.size());
    EXPECT_LT(confidence, last_confidence);
    EXPECT_GT(estimate.noise_mm, last_noise);
    if (noise > 0) {
      EXPECT_NEAR(estimate.noise_mm, 0.6745 * noise, 0.1 * noise + 0.05);  // the median of |N(0, noise)|
    }
    last_confidence = confidence;
    last_noise = estimate.noise_mm;
  }
}

TEST(EstimateNormals, TheFacesOfAThinSheetPointApart) {
  PointCloud cloud;  // an ear: 4 mm thick, 60 mm wide, open at the rim
  for (const float z : {0.0f, 4.0f})
    for (float y = -30; y <= 30; y += 0.9f)
      for (float x = -30; x <= 30; x += 0.9f) cloud.positions.emplace_back(x, y, z);
  estimate_normals(cloud, 1.6f, no_guide());
  for (std::size_t i = 0; i < cloud.size(); ++i)
    ASSERT_GT(cloud.normals[i].z() * (cloud.positions[i].z() - 2), 1.9f) << cloud.positions[i].transpose();
}

TEST(EstimateNormals, InAHollowTheGuideDecides) {
  // A slit between two walls 3 mm apart, shut at the sides: sight tells nothing deep inside.
  PointCloud cloud;
  OrientationGuide guide;
  for (const float side : {-1.0f, 1.0f})
    for (float y = -30; y <= 30; y += 0.8f)
      for (float x = -30; x <= 30; x += 0.8f) {
        cloud.positions.emplace_back(x, y, 1.5f * side);
        guide.positions.emplace_back(x, y, 1.5f * side);
        guide.normals.emplace_back(0.0f, 0.0f, -side);  // facing each other
      }
  for (int side = 0; side < 2; ++side)  // shells outside that hide the outer sides
    for (float y = -40; y <= 40; y += 0.8f)
      for (float x = -40; x <= 40; x += 0.8f) cloud.positions.emplace_back(x, y, side ? 6.0f : -6.0f);
  const std::size_t walls = guide.positions.size();
  estimate_normals(cloud, 1.6f, guide);
  std::size_t right = 0;
  for (std::size_t i = 0; i < walls; ++i) {
    if (cloud.positions[i].head<2>().cwiseAbs().maxCoeff() > 20)
      ++right;
    else
      right += cloud.normals[i].z() * cloud.positions[i].z() < 0;
  }
  EXPECT_GT(double(right) / double(walls), 0.98);
}

TEST(EstimateNormals, AHollowFollowsItsRim) {
  // A dent in a plate, nothing scanned behind it: more rays leave its back than its mouth. The guide knows
  // the plate only.
  constexpr float kDepth = 8, kWidth = 4;
  PointCloud cloud;
  OrientationGuide guide;
  for (float y = -30; y <= 30; y += 0.7f)
    for (float x = -30; x <= 30; x += 0.7f) {
      const float r = std::hypot(x, y);
      cloud.positions.emplace_back(x, y, -kDepth * std::exp(-r * r / (2 * kWidth * kWidth)));
      if (r < 3 * kWidth) continue;
      guide.positions.emplace_back(x, y, 0.0f);
      guide.normals.emplace_back(0.0f, 0.0f, 1.0f);
    }
  estimate_normals(cloud, 1.6f, guide);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    ASSERT_GT(cloud.normals[i].z(), 0) << cloud.positions[i].transpose();
}

TEST(EstimateNormals, LonePointsHaveNoConfidence) {
  PointCloud cloud = make_sphere(5000, 40, 0);
  cloud.positions.emplace_back(300.0f, 0.0f, 0.0f);
  estimate_normals(cloud, 3.0f, no_guide());
  EXPECT_EQ(cloud.confidences.back(), 0);
  EXPECT_TRUE(cloud.normals.back().allFinite());
}

TEST(EstimateNormals, PointsInALineOrAtOnePlaceGetFiniteNormals) {
  PointCloud cloud;
  for (int i = 0; i < 50; ++i) cloud.positions.emplace_back(0.1f * float(i), 0.0f, 0.0f);
  for (int i = 0; i < 50; ++i) cloud.positions.emplace_back(50.0f, 50.0f, 50.0f);
  estimate_normals(cloud, 1.6f, no_guide());
  for (const auto& n : cloud.normals) EXPECT_NEAR(n.norm(), 1, 1e-4f);
}

TEST(EstimateNormals, SameBitsAtAnyThreadCount) {
  PointCloud one = make_sphere(8000, 60, 0.2), two = one;
  with_threads(1, [&] { estimate_normals(one, 4.0f, no_guide()); });
  with_threads(2, [&] { estimate_normals(two, 4.0f, no_guide()); });
  EXPECT_EQ(one.normals, two.normals);
  EXPECT_EQ(one.confidences, two.confidences);
}

}  // namespace
}  // namespace phiz
