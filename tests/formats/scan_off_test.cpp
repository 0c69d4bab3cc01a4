#include <gtest/gtest.h>

#include "tests/formats/scan_samples.h"

namespace phiz::test {
namespace {

TEST(ScanOff, GivesBackPositionsNormalsColoursAndTriangles) {
  const ScanSample sample = make_sample();
  const ScanFile scan = parse(write_off_text(sample));
  EXPECT_EQ(scan.format, "off");
  EXPECT_EQ(scan.points.positions, sample.positions);
  EXPECT_EQ(scan.points.colours, sample.colours);
  EXPECT_EQ(scan.triangles, sample.triangles);
  ASSERT_EQ(scan.points.normals.size(), sample.normals.size());
  for (std::size_t i = 0; i < sample.normals.size(); ++i)
    EXPECT_LT((scan.points.normals[i] - sample.normals[i]).norm(), 1e-6f);
}

TEST(ScanOff, TakesCountsFromTheKeywordsLineOrTheNext) {
  const std::string rows = "0 0 0\n1 0 0 # here\n\n1 1 0\n0 1 0\n4 0 1 2 3 0.5 0.5 0.5\n";
  const std::vector<Eigen::Vector3i> expected = {{0, 1, 2}, {0, 2, 3}};
  for (const char* head :
       {"OFF\n4 1 0\n", "OFF 4 1 0\n", "OFF4 1 0\n", "# a square\nOFF\r\n# counts\r\n4 1\r\n"})
    EXPECT_EQ(parse(head + rows).triangles, expected) << head;
}

TEST(ScanOff, ReadsColoursAsPartsOfOneToo) {
  const ScanFile scan = parse("COFF\n2 0 0\n0 0 0 1.0 0.5 0.0 1.0\n1 0 0 0 0 0 1\n");
  EXPECT_EQ(scan.points.colours.at(0), (std::array<std::uint8_t, 3>{255, 128, 0}));
}

TEST(ScanOff, SaysWhatIsWrong) {
  EXPECT_NE(fault_of("OFF\n4000000000 0 0\n0 0 0\n").find("4000000000 points"), std::string::npos);
  EXPECT_NE(fault_of("OFF\n1 4000000000 0\n0 0 0\n").find("(line 2)"), std::string::npos);
  EXPECT_NE(fault_of("OFF\n1 0 0\n0 abc 0\n").find("'abc' is not a number (line 3)"), std::string::npos);
  EXPECT_NE(fault_of("OFF\n1 1 0\n0 0 0\n3 0 0 1\n").find("names vertex 1 of 1 (line 4)"), std::string::npos);
  EXPECT_NE(fault_of("OFF\n2 0 0\n0 0 0 0 0 0\n").find("a vertex is missing (line 3)"), std::string::npos);
  EXPECT_NE(fault_of("OFF BINARY\n").find("is binary OFF"), std::string::npos);
  EXPECT_NE(fault_of("4OFF\n1 0 0\n0 0 0 0\n").find("not in three dimensions"), std::string::npos);
}

}  // namespace
}  // namespace phiz::test
