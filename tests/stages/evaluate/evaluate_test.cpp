#include "stages/evaluate/evaluate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "formats/triangle_mesh.h"
#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz::test {
namespace {

using Eigen::Vector3f;

TriangleMesh sphere(int level, float radius) {
  TriangleMesh mesh = icosphere(level);
  for (Vector3f& p : mesh.positions) p *= radius;
  return mesh;
}

SurfaceView view(const TriangleMesh& mesh) {
  return {mesh.positions, mesh.triangles};
}

TEST(ErrorStats, AreNearestRanks) {
  std::vector<double> values;
  for (int i = 100; i >= 1; --i) values.push_back(i);
  const ErrorStats stats = compute_error_stats(values);
  EXPECT_EQ(stats.count, 100u);
  EXPECT_DOUBLE_EQ(stats.mean, 50.5);
  EXPECT_EQ(stats.median, 50);
  EXPECT_EQ(stats.p95, 95);
  EXPECT_EQ(stats.p99, 99);
  EXPECT_EQ(stats.max, 100);
  EXPECT_EQ(compute_error_stats({}).count, 0u);
}

TEST(SurfaceErrors, OfASurfaceAgainstItselfAreZero) {
  const TriangleMesh mesh = sphere(3, 80);
  const SurfaceErrors errors = compute_surface_errors(view(mesh), {}, view(mesh), mesh.positions);
  EXPECT_EQ(errors.truth_to_fitted.count, mesh.positions.size());
  EXPECT_LT(errors.truth_to_fitted.max, 1e-5);
  EXPECT_LT(errors.fitted_to_truth.max, 1e-5);
}

TEST(SurfaceErrors, OfAnOffsetSphereAreTheOffset) {
  const TriangleMesh truth = sphere(4, 80), fitted = sphere(4, 80.5f);
  const SurfaceErrors errors = compute_surface_errors(view(fitted), {}, view(truth), truth.positions);
  // facets of the outer sphere sag inwards by at most the sagitta of an edge
  EXPECT_NEAR(errors.truth_to_fitted.mean, 0.5, 0.08);
  EXPECT_NEAR(errors.fitted_to_truth.median, 0.5, 1e-3);
  EXPECT_NEAR(errors.fitted_to_truth.max, 0.5, 1e-3);
}

TEST(SurfaceErrors, OnlyTruthThatTheScanSawCounts) {
  const TriangleMesh truth = sphere(3, 80);
  std::vector<Vector3f> cloud;
  std::size_t upper = 0;
  for (const Vector3f& p : truth.positions) {
    if (p.y() < 0) continue;
    cloud.push_back(p * 1.005f);  // 0.4 mm off
    ++upper;
  }
  EXPECT_EQ(compute_surface_errors(view(truth), {}, view(truth), cloud).truth_to_fitted.count, upper);
}

TEST(SurfaceErrors, AreSortedByRegionAndConfidence) {
  TriangleMesh fitted = sphere(3, 80);
  const TriangleMesh truth = sphere(3, 80);
  FittedLabels labels;
  std::vector<bool>& left = labels.regions["left"];
  for (Vector3f& p : fitted.positions) {
    const bool is_left = p.x() > 20;
    left.push_back(is_left);
    labels.confidences.push_back(is_left ? 255 : 0);
    if (is_left) p *= 1.0125f;  // 1 mm
  }
  const SurfaceErrors errors = compute_surface_errors(view(fitted), labels, view(truth), truth.positions);
  EXPECT_NEAR(errors.fitted_to_truth_by_region.at("left").mean, 1.0, 1e-3);
  EXPECT_NEAR(errors.fitted_to_truth_by_confidence.at("measured").mean, 1.0, 1e-3);
  EXPECT_LT(errors.fitted_to_truth_by_confidence.at("invented").max, 1e-5);
  EXPECT_GT(errors.truth_to_fitted_by_region.at("left").median, 0.7);
  EXPECT_EQ(errors.fitted_to_truth_by_confidence.count("bridged"), 0u);
}

TEST(SurfaceErrors, WrongSizesAreRefused) {
  const TriangleMesh mesh = sphere(1, 80);
  FittedLabels labels;
  labels.regions["left"] = {true};
  EXPECT_THROW(compute_surface_errors(view(mesh), labels, view(mesh), mesh.positions), InvalidInput);
  labels = {};
  labels.confidences = {1, 2};
  EXPECT_THROW(compute_surface_errors(view(mesh), labels, view(mesh), mesh.positions), InvalidInput);
  EXPECT_THROW(compute_distances(mesh.positions, {mesh.positions, {}}), InvalidInput);
}

TEST(Distances, OfPointsAboveAPlaneAreTheirHeights) {
  const TriangleMesh grid = open_grid(4, 4);
  std::vector<Vector3f> points;
  for (int i = 0; i < 50; ++i) {
    points.emplace_back(random().uniform(0.1, 0.9), random().uniform(0.1, 0.9), random().uniform(-1, 1));
  }
  const std::vector<double> distances = compute_distances(points, view(grid));
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(distances[i], std::abs(points[i].z()), 1e-6);
}

TEST(Correspondence, OfIdenticalParameterisationsIsZero) {
  const TriangleMesh truth_a = sphere(3, 80);
  std::vector<Vector3f> truth_b;
  for (const Vector3f& p : truth_a.positions) truth_b.push_back({1.2f * p.x(), p.y() + 0.1f * p.z(), p.z()});
  const auto errors = compute_correspondence_errors(
      {truth_a.positions, truth_b, truth_a.positions, truth_b, truth_a.triangles});
  EXPECT_EQ(errors.all.count, truth_b.size());
  EXPECT_LT(errors.all.max, 1e-4);
}

TEST(Correspondence, IsWhatVerticesSlideOnB) {
  const TriangleMesh truth = sphere(3, 80);
  std::vector<Vector3f> slid = truth.positions;
  for (std::size_t v = 0; v < slid.size(); v += 2) slid[v] += Vector3f(0, 3, 0);
  CorrespondenceOptions options;
  options.regions["even"].resize(slid.size());
  for (std::size_t v = 0; v < slid.size(); v += 2) options.regions["even"][v] = true;
  const auto errors = compute_correspondence_errors(
      {truth.positions, slid, truth.positions, truth.positions, truth.triangles}, options);
  EXPECT_NEAR(errors.by_region.at("even").mean, 3.0, 1e-4);
  EXPECT_NEAR(errors.distances_mm[1], 0.0, 1e-4);
}

TEST(Correspondence, FarVerticesAreNotCounted) {
  const TriangleMesh truth = sphere(2, 80);
  std::vector<Vector3f> fitted = truth.positions;
  fitted[7] *= 1.5f;
  const auto errors = compute_correspondence_errors(
      {fitted, truth.positions, truth.positions, truth.positions, truth.triangles});
  EXPECT_EQ(errors.all.count, fitted.size() - 1);
  EXPECT_TRUE(std::isnan(errors.distances_mm[7]));
}

TEST(Correspondence, DifferentIndexingsAreRefused) {
  const TriangleMesh a = sphere(1, 80), b = sphere(2, 80);
  EXPECT_THROW(
      compute_correspondence_errors({a.positions, b.positions, a.positions, a.positions, a.triangles}),
      InvalidInput);
  EXPECT_THROW(
      compute_correspondence_errors({a.positions, a.positions, a.positions, b.positions, a.triangles}),
      InvalidInput);
}

TEST(Regions, OfFinerLevelsLieBetweenTheirVertices) {
  const TriangleMesh mesh = icosphere(1);
  Annotations annotations;
  annotations.regions["face"] = {mesh.triangles[0][0], mesh.triangles[0][1], mesh.triangles[0][2]};
  annotations.regions["ears"] = {mesh.triangles[40][0]};
  const SubdivisionHierarchy hierarchy(mesh.triangles, static_cast<int>(mesh.positions.size()), 2);
  const Regions regions = refine_regions(hierarchy, annotations, 2);
  for (const auto& [name, flags] : regions) ASSERT_EQ(flags.size(), hierarchy.vertex_count(2) + 0u) << name;
  for (int t = 0; t < 16; ++t) {  // the sixteen grandchildren of triangle 0
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(regions.at("face")[hierarchy.triangles(2)[t][i]]);
  }
  EXPECT_TRUE(regions.at("face_and_ears")[mesh.triangles[40][0]]);
}

TEST(Landmarks, AreComparedByName) {
  const auto errors =
      compute_landmark_errors({{"chin", {0, 0, 0}}, {"own", {1, 1, 1}}}, {{"chin", {0, 3, 4}}});
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_EQ(errors.at("chin"), 5.0);
}

}  // namespace
}  // namespace phiz::test
