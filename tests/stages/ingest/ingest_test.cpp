#include "stages/ingest/ingest.h"

#include <gtest/gtest.h>

#include <cmath>

#include "stages/geometry/error.h"
#include "stages/geometry/normals.h"
#include "stages/geometry/parallel.h"
#include "stages/geometry/surface_index.h"
#include "tests/stages/ingest/ingest_samples.h"
#include "tests/stages/synth/synth_samples.h"

namespace phiz {
namespace {

using namespace test;

void expect_near_truth(const IngestResult& result, const Eigen::Matrix4d& scan_from_truth, double turn_deg,
                       double shift_mm) {
  const PoseError error = pose_error(result, scan_from_truth);
  EXPECT_LT(error.turn_deg, turn_deg);
  EXPECT_LT(error.shift_mm, shift_mm);
  EXPECT_NEAR(error.scale, 1, 1e-6);  // the unit is found; the head's size is head_scale
}

TEST(Ingest, FindsPoseAndUnitWhateverTheAxes) {
  const struct {
    const char* name;
    double units_per_mm;
  } units[] = {{"mm", 1}, {"cm", 0.1}, {"m", 0.001}, {"in", 1 / 25.4}};
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto& unit = units[seed % 4];
    SCOPED_TRACE("pose " + std::to_string(seed) + " in " + unit.name);
    const Eigen::Matrix4d scan_from_truth = draw_scan_pose(seed, unit.units_per_mm);
    const IngestResult result = ingest(posed(subject_scan(seed % 2), scan_from_truth), generic_head());
    EXPECT_EQ(result.summary.unit, unit.name);
    expect_near_truth(result, scan_from_truth, 6, 10);
    EXPECT_NEAR(result.head_scale, 1, 0.15);
  }
}

TEST(Ingest, TheFrameFoundHardlyDependsOnThePose) {
  const Eigen::Matrix4d identity = Eigen::Matrix4d::Identity();
  const IngestResult upright = ingest(posed(subject_scan(1), identity), generic_head());
  for (std::uint64_t seed = 20; seed < 22; ++seed) {
    const Eigen::Matrix4d scan_from_truth = draw_scan_pose(seed, 1.0);
    const IngestResult turned = ingest(posed(subject_scan(1), scan_from_truth), generic_head());
    const PoseError apart = pose_error(turned, scan_from_truth * upright.scan_from_head);
    EXPECT_LT(apart.turn_deg, 1.0);
    EXPECT_LT(apart.shift_mm, 2.0);
    EXPECT_NEAR(turned.head_scale, upright.head_scale, 0.01);
  }
}

TEST(Ingest, CloudIsTheScanInTheHeadFrame) {
  const Eigen::Matrix4d scan_from_truth = draw_scan_pose(5, 0.1);
  const IngestResult result = ingest(posed(subject_scan(0), scan_from_truth), generic_head());
  const Eigen::Matrix4d truth_from_head = scan_from_truth.inverse() * result.scan_from_head;
  const SubjectBase& base = generic_base(2);
  const ScanTarget target = make_scan_target(base, make_subject(base, draw_recipe(0, 0.7)));
  const SurfaceIndex index(target.mesh.positions, target.mesh.triangles);
  std::vector<Eigen::Vector3d> doubles;
  for (const auto& p : target.mesh.positions) doubles.push_back(p.cast<double>());
  const auto normals = compute_vertex_normals(doubles, target.mesh.triangles);
  int near = 0, outward = 0;
  for (std::size_t i = 0; i < result.cloud.size(); ++i) {
    const Eigen::Vector3d p =
        (truth_from_head * result.cloud.positions[i].cast<double>().homogeneous()).head<3>();
    const auto hit = index.find_nearest(p, 5.0);
    if (!hit || hit->distance > 1) continue;
    ++near;
    const Eigen::Vector3d n = truth_from_head.topLeftCorner<3, 3>() * result.cloud.normals[i].cast<double>();
    const Eigen::Vector3i& t = target.mesh.triangles[hit->triangle_idx];
    outward += n.dot(normals[t[0]] + normals[t[1]] + normals[t[2]]) > 0;
  }
  EXPECT_GT(near, 0.95 * double(result.cloud.size()));
  EXPECT_GT(outward, 0.99 * near);
}

TEST(Ingest, HoldsThePromisesOfItsCloudAndSummary) {
  const IngestResult result = ingest(posed(subject_scan(0), draw_scan_pose(2, 1.0)), generic_head());
  const PointCloud& cloud = result.cloud;
  const IngestSummary& s = result.summary;
  ASSERT_EQ(cloud.normals.size(), cloud.size());
  ASSERT_EQ(cloud.confidences.size(), cloud.size());
  ASSERT_EQ(cloud.colours.size(), cloud.size());
  EXPECT_EQ(s.points_kept, cloud.size());
  EXPECT_EQ(s.points_read, s.removed_non_finite + s.points_sampled);
  EXPECT_EQ(s.points_sampled, s.points_kept + s.removed_far + s.removed_outliers + s.removed_below_neck);
  EXPECT_GT(s.removed_below_neck, 0u);
  EXPECT_GT(s.coverage, 0.6);
  EXPECT_LE(s.coverage, 1.0);
  EXPECT_LT(s.pose_score, IngestOptions{}.reject_score);
  EXPECT_LT(s.pose_mismatch, IngestOptions{}.reject_mismatch);
  const Plane& neck = generic_head().annotations.clipping_planes.at("neck");
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    ASSERT_GE(neck.normal.dot(cloud.positions[i].cast<double>()), neck.offset_mm * result.head_scale - 1e-3);
    ASSERT_NEAR(cloud.normals[i].norm(), 1, 1e-4f);
    ASSERT_TRUE(cloud.confidences[i] >= 0 && cloud.confidences[i] <= 1);
  }
  EXPECT_FALSE(result.distance_field.coordinates.empty());
}

TEST(Ingest, SameBitsAtAnyThreadCount) {
  const ScanFile scan = posed(subject_scan(1), draw_scan_pose(3, 1.0));
  IngestResult one, two;
  with_threads(1, [&] { one = ingest(scan, generic_head()); });
  with_threads(2, [&] { two = ingest(scan, generic_head()); });
  EXPECT_EQ(one.scan_from_head, two.scan_from_head);
  EXPECT_EQ(one.cloud.positions, two.cloud.positions);
  EXPECT_EQ(one.cloud.normals, two.cloud.normals);
  EXPECT_EQ(one.cloud.confidences, two.cloud.confidences);
  EXPECT_EQ(one.distance_field.distances_mm, two.distance_field.distances_mm);
  EXPECT_EQ(one.distance_field.confidences, two.distance_field.confidences);
}

TEST(Ingest, AStatedUnitIsTaken) {
  IngestOptions options;
  options.mm_per_unit = 20;  // a bust at half size, in centimetres
  const IngestResult result =
      ingest(posed(subject_scan(0), draw_scan_pose(4, 0.05)), generic_head(), options);
  EXPECT_EQ(result.summary.unit, "stated");
  EXPECT_NEAR(result.head_scale, 1, 0.15);
}

TEST(Ingest, AnUnknownUnitIsTakenForAHeadOfCommonSize) {
  const IngestResult result = ingest(posed(subject_scan(0), draw_scan_pose(4, 40)), generic_head());
  EXPECT_EQ(result.summary.unit, "unknown");
  EXPECT_NEAR(result.head_scale, 1, 1e-9);
}

TEST(Ingest, TheOriginOfTheFileComesBack) {
  const Eigen::Matrix4d scan_from_truth = draw_scan_pose(6, 1.0);
  ScanFile scan = posed(subject_scan(0), scan_from_truth);
  const IngestResult plain = ingest(scan, generic_head());
  scan.origin = Eigen::Vector3d(4e6, -5e5, 100);
  const IngestResult moved = ingest(scan, generic_head());
  EXPECT_EQ(moved.cloud.positions, plain.cloud.positions);
  Eigen::Matrix4d expected = plain.scan_from_head;
  expected.topRightCorner<3, 1>() += scan.origin;
  EXPECT_LT((moved.scan_from_head - expected).norm(), 1e-6);
}

TEST(Ingest, SamplesAMeshByArea) {
  const SubjectBase& base = generic_base(2);
  ScanFile scan;
  for (const auto& p : make_subject(base, draw_recipe(3, 0.7)))
    scan.points.positions.push_back(p.cast<float>());
  scan.triangles = base.triangles;
  IngestOptions options;
  options.soup_samples = 30'000;
  const IngestResult result = ingest(scan, generic_head(), options);
  EXPECT_EQ(result.summary.points_sampled, 30'000u);
  expect_near_truth(result, Eigen::Matrix4d::Identity(), 6, 10);
}

TEST(Ingest, ThinsToTheMostPointsAskedFor) {
  IngestOptions options;
  options.max_points = 10'000;
  const Eigen::Matrix4d scan_from_truth = draw_scan_pose(7, 1.0);
  const IngestResult result = ingest(posed(subject_scan(0), scan_from_truth), generic_head(), options);
  EXPECT_EQ(result.summary.points_sampled, 10'000u);
  expect_near_truth(result, scan_from_truth, 6, 10);
}

}  // namespace
}  // namespace phiz
