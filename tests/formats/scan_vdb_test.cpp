#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <sstream>

#include "tests/formats/scan_samples.h"

namespace phiz::test {
namespace {

std::string write_sample_vdb(const ScanSample& sample) {
  PointCloud cloud;
  cloud.positions = sample.positions;
  cloud.colours = sample.colours;
  std::ostringstream out;
  write_vdb(cloud, out);
  return out.str();
}

TEST(ScanVdb, GivesBackThePointsInAnyOrder) {
  const ScanSample sample = make_sample();
  const ScanFile scan = parse(write_sample_vdb(sample));
  EXPECT_EQ(scan.format, "vdb");
  ASSERT_EQ(scan.points.size(), sample.positions.size());
  ASSERT_EQ(scan.points.colours.size(), sample.positions.size());
  for (std::size_t i = 0; i < sample.positions.size(); ++i) {
    const auto distance_to = [&](const Eigen::Vector3f& p) { return (p - sample.positions[i]).norm(); };
    std::size_t nearest = 0;
    for (std::size_t k = 1; k < scan.points.size(); ++k)
      if (distance_to(scan.points.positions[k]) < distance_to(scan.points.positions[nearest])) nearest = k;
    EXPECT_LT(distance_to(scan.points.positions[nearest]), 1e-3f);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(scan.points.colours[nearest][c], sample.colours[i][c], 1);
  }
}

TEST(ScanVdb, RefusesEachTruncation) {
  const std::string whole = write_sample_vdb(make_sample());
  for (std::size_t size = 0; size < whole.size(); size += 1 + size / 64)
    EXPECT_NE(fault_of(whole.substr(0, size), ".vdb"), "") << size;
}

}  // namespace
}  // namespace phiz::test
