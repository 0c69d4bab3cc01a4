#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "stages/geometry/error.h"
#include "tests/stages/ingest/ingest_samples.h"
#include "tests/stages/synth/synth_samples.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using namespace test;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

void expect_found(const PointCloud& cloud, double turn_deg = 6, double shift_mm = 10) {
  const Eigen::Matrix4d scan_from_truth = draw_scan_pose(9, 1.0);
  const PoseError error = pose_error(ingest(posed(cloud, scan_from_truth), generic_head()), scan_from_truth);
  EXPECT_LT(error.turn_deg, turn_deg);
  EXPECT_LT(error.shift_mm, shift_mm);
}

TEST(IngestHostile, RejectsWhatIsNoHead) {
  EXPECT_THROW(ingest(make_scan(sphere_points(20'000, 100)), generic_head()), FitRejected) << "sphere";
  EXPECT_THROW(ingest(make_scan(cube_points(20'000, 200)), generic_head()), FitRejected) << "cube";
  EXPECT_THROW(ingest(make_scan(plane_points(20'000, 200)), generic_head()), FitRejected) << "plane";
  EXPECT_THROW(ingest(make_scan(horse_points(20'000)), generic_head()), FitRejected) << "horse";
}

TEST(IngestHostile, RefusesTooFewPoints) {
  PointCloud cloud;
  EXPECT_THROW(ingest(make_scan(cloud), generic_head()), InvalidInput);
  cloud = sphere_points(999, 100);
  EXPECT_THROW(ingest(make_scan(cloud), generic_head()), InvalidInput);
  cloud = sphere_points(3000, 100);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (i % 4) cloud.positions[i][int(i % 3)] = i % 2 ? kNan : kInfinity;
  EXPECT_THROW(ingest(make_scan(cloud), generic_head()), InvalidInput);
}

TEST(IngestHostile, RefusesPointsWithoutExtent) {
  PointCloud cloud;
  cloud.positions.assign(5000, Eigen::Vector3f(3, 4, 5));
  EXPECT_THROW(ingest(make_scan(cloud), generic_head()), InvalidInput);
  for (std::size_t i = 0; i < cloud.size(); i += 2) cloud.positions[i].x() = 8;  // two places
  EXPECT_THROW(ingest(make_scan(cloud), generic_head()), InvalidInput);
}

TEST(IngestHostile, ALineOfPointsIsRefused) {
  PointCloud cloud;
  for (int i = 0; i < 5000; ++i) cloud.positions.emplace_back(0.1f * float(i), 0.0f, 0.0f);
  try {
    ingest(make_scan(cloud), generic_head());
    FAIL() << "taken for a head";
  } catch (const InvalidInput&) {
  } catch (const FitRejected&) {
  }
}

TEST(IngestHostile, RefusesAMeshWithoutArea) {
  ScanFile scan = make_scan(subject_scan(0));
  scan.triangles.assign(4000, Eigen::Vector3i(0, 0, 1));
  EXPECT_THROW(ingest(scan, generic_head()), InvalidInput);
}

TEST(IngestHostile, SprinkledNansAndInfinitiesAreDropped) {
  PointCloud cloud = subject_scan(0);
  std::size_t spoilt = 0;
  for (auto& p : cloud.positions) {
    if (random().below(20)) continue;
    p[int(random().below(3))] = random().below(2) ? kNan : -kInfinity;
    ++spoilt;
  }
  const Eigen::Matrix4d identity = Eigen::Matrix4d::Identity();
  ScanFile scan = make_scan(cloud);
  const IngestResult result = ingest(scan, generic_head());
  EXPECT_EQ(result.summary.removed_non_finite, spoilt);
  EXPECT_LT(pose_error(result, identity).turn_deg, 6);
}

TEST(IngestHostile, NumbersBeyondMeasureAreDropped) {
  PointCloud cloud = subject_scan(0);
  for (int i = 0; i < 30; ++i)
    cloud.positions[std::size_t(i) * 700] = Eigen::Vector3f::Constant(i % 2 ? 3e38f : -1e25f);
  const IngestResult result = ingest(make_scan(cloud), generic_head());
  EXPECT_LT(pose_error(result, Eigen::Matrix4d::Identity()).turn_deg, 6);
}

TEST(IngestHostile, AFewPointsMetresAwayDoNotMatter) {
  for (const float far_mm : {3e3f, 1e7f}) {
    SCOPED_TRACE(far_mm);
    PointCloud cloud = subject_scan(0);
    for (int i = 0; i < 6; ++i)
      cloud.positions[std::size_t(i) * 700] =
          far_mm * Eigen::Vector3f(i % 2 ? 1 : -1, i % 3 ? 1 : -1, 0.1f * float(i) - 0.3f);
    expect_found(cloud);
  }
}

TEST(IngestHostile, RepeatedPointsDoNotMatter) {
  PointCloud cloud = subject_scan(0);
  const PointCloud once = cloud;
  for (int copy = 0; copy < 2; ++copy) {
    cloud.positions.insert(cloud.positions.end(), once.positions.begin(), once.positions.end());
    cloud.colours.insert(cloud.colours.end(), once.colours.begin(), once.colours.end());
  }
  expect_found(cloud);
}

TEST(IngestHostile, AHeapAtOnePlaceDoesNotMatter) {
  PointCloud cloud = subject_scan(0);
  for (std::size_t i = 0; i < cloud.size(); i += 10) cloud.positions[i] = Eigen::Vector3f::Zero();
  expect_found(cloud);
}

TEST(IngestHostile, AThousandPointsEndWellOrInOneOfItsErrors) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    const PointCloud& scan = subject_scan(seed % 2);
    PointCloud cloud;
    for (int i = 0; i < 1200; ++i) cloud.positions.push_back(scan.positions[random().below(scan.size())]);
    try {
      const IngestResult result = ingest(make_scan(cloud), generic_head());
      EXPECT_LT(pose_error(result, Eigen::Matrix4d::Identity()).turn_deg, 15);
      for (const auto& n : result.cloud.normals) ASSERT_TRUE(n.allFinite());
    } catch (const InvalidInput&) {
    } catch (const FitRejected&) {
    }
  }
}

TEST(IngestHostile, TrianglesWithoutAreaDoNotMatter) {
  const SubjectBase& base = generic_base(2);
  ScanFile scan;
  for (const auto& p : base.positions) scan.points.positions.push_back(p.cast<float>());
  scan.points.positions.emplace_back(kNan, kNan, kNan);
  const int last = int(scan.points.positions.size()) - 1;
  for (const auto& t : base.triangles) {
    scan.triangles.push_back(t);
    if (random().below(4)) continue;
    scan.triangles.push_back({t[0], t[0], t[1]});
    scan.triangles.push_back({t[0], t[1], last});
  }
  IngestOptions options;
  options.soup_samples = 20'000;
  const IngestResult result = ingest(scan, generic_head(), options);
  EXPECT_EQ(result.summary.removed_non_finite, 0u);
  EXPECT_LT(pose_error(result, Eigen::Matrix4d::Identity()).turn_deg, 2);
}

TEST(IngestHostile, AGenericHeadWithoutNeckPlaneIsNamed) {
  ControlMesh head = generic_head();
  head.annotations.clipping_planes.clear();
  EXPECT_THROW(ingest(make_scan(subject_scan(0)), head), InvalidInput);
}

}  // namespace
}  // namespace phiz
