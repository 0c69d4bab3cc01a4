#include <gtest/gtest.h>

#include "tests/formats/scan_samples.h"

namespace phiz::test {
namespace {

TEST(ScanDrc, GivesBackMeshesAndClouds) {
  const ScanSample sample = make_sample();
  for (const bool as_mesh : {true, false}) {
    const ScanFile scan = parse(write_drc(sample, as_mesh));
    EXPECT_EQ(scan.format, "drc");
    EXPECT_EQ(scan.points.positions, sample.positions);
    EXPECT_EQ(scan.points.colours, sample.colours);
    EXPECT_EQ(scan.triangles, as_mesh ? sample.triangles : std::vector<Eigen::Vector3i>{});
    ASSERT_EQ(scan.points.normals.size(), sample.normals.size());
    for (std::size_t i = 0; i < sample.normals.size(); ++i)
      EXPECT_LT((scan.points.normals[i] - sample.normals[i]).norm(), 1e-6f);
  }
}

TEST(ScanDrc, RefusesLyingCountsBeforeDecoding) {
  const std::string cloud = write_drc(make_sample(), false), mesh = write_drc(make_sample(), true);
  std::string lie = cloud;
  lie.replace(11, 4, "\xFF\xFF\xFF\x7F");
  EXPECT_NE(fault_of(lie).find("says it holds 2147483647 points in"), std::string::npos);
  lie = mesh.substr(0, 11) + "\xFF\xFF\xFF\xFF\x0F" + mesh.substr(12);  // faces
  EXPECT_NE(fault_of(lie).find("says it holds"), std::string::npos);
  lie = mesh.substr(0, 12) + "\xFF\xFF\xFF\xFF\x0F" + mesh.substr(13);  // points
  EXPECT_NE(fault_of(lie).find("says it holds"), std::string::npos);
}

TEST(ScanDrc, RefusesOldStreamsWithAdvice) {
  std::string old = write_drc(make_sample(), true);
  old[6] = '\1';
  EXPECT_NE(fault_of(old).find("older than 2.2 (byte 0) | encode it again"), std::string::npos);
}

}  // namespace
}  // namespace phiz::test
