#include <gtest/gtest.h>

#include "tests/formats/scan_samples.h"

namespace phiz::test {
namespace {

TEST(ScanObj, GivesBackPositionsColoursNormalsAndTriangles) {
  const ScanSample sample = make_sample();
  const ScanFile scan = parse(write_obj_text(sample));
  EXPECT_EQ(scan.format, "obj");
  EXPECT_EQ(scan.points.positions, sample.positions);
  EXPECT_EQ(scan.points.colours, sample.colours);
  EXPECT_EQ(scan.triangles, sample.triangles);
  ASSERT_TRUE(scan.points.has_normals());
  for (std::size_t i = 0; i < sample.normals.size(); ++i)
    EXPECT_LT((scan.points.normals[i] - sample.normals[i]).norm(), 1e-6f);
}

TEST(ScanObj, UnderstandsEachFormOfACorner) {
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0 1.0\nvt 0 0\nvn 0 0 2\n";
  const std::vector<Eigen::Vector3i> expected = {{0, 1, 2}, {0, 2, 3}};
  for (const char* face :
       {"f 1 2 3 4", "f 1/1 2/1 3/1 4/1", "f 1/1/1 2/1/1 3/1/1 4/1/1", "f 1//1 2//1 3//1 4//1",
        "f -4 -3 -2 -1", "f -4/-1/-1 -3/-1/-1 -2/-1/-1 -1/-1/-1", "f 1 \\\n  2 3 \\\r\n4"}) {
    SCOPED_TRACE(face);
    const ScanFile scan = parse(square + face + "\n");
    EXPECT_EQ(scan.triangles, expected);
    EXPECT_EQ(scan.points.size(), 4u);
    if (scan.points.has_normals()) {
      EXPECT_EQ(scan.points.normals[2], Eigen::Vector3f(0, 0, 1));
    }
  }
}

TEST(ScanObj, MeansTheNormalsOfAVertexAndLeavesUnusedVerticesWithoutOne) {
  const ScanFile scan = parse(
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 9 9 9\nvn 1 0 0\nvn 0 1 0\nf 1//1 2//1 3//1\nf 1//2 3//2 "
      "4//2\n");
  EXPECT_LT((scan.points.normals.at(0) - Eigen::Vector3f(1, 1, 0).normalized()).norm(), 1e-6f);
  EXPECT_EQ(scan.points.normals.at(1), Eigen::Vector3f(1, 0, 0));
  EXPECT_EQ(scan.points.normals.at(4), Eigen::Vector3f::Zero());
}

TEST(ScanObj, TakesNormalsByOrderWhereThereAreNoFaces) {
  const ScanFile scan = parse("v 0 0 0\nvn 0 3 0\nv 1 0 0\nvn 0 0 1\n");
  ASSERT_EQ(scan.points.normals.size(), 2u);
  EXPECT_EQ(scan.points.normals[0], Eigen::Vector3f(0, 1, 0));
}

TEST(ScanObj, DropsColoursThatOnlySomeVerticesHave) {
  EXPECT_FALSE(parse("v 0 0 0 1 1 1\nv 1 0 0\n").points.has_colours());
  EXPECT_FALSE(parse("v 0 0 0\nv 1 0 0 1 1 1\n").points.has_colours());
  EXPECT_EQ(parse("v 0 0 0 255 128 0\n").points.colours.at(0), (std::array<std::uint8_t, 3>{255, 128, 0}));
}

TEST(ScanObj, NamesTheLineOfWhatIsWrong) {
  EXPECT_NE(fault_of("v 0 0 0\nv 1 abc 0\n").find("'abc' is not a number (line 2)"), std::string::npos);
  EXPECT_NE(fault_of("v 0 0 0\nv 1 2\n").find("less than three coordinates (line 2)"), std::string::npos);
  EXPECT_NE(fault_of("v 0 0 0\nf 1 1 2\n\n").find("names vertex 2 of 1 (line 2)"), std::string::npos);
  EXPECT_NE(fault_of("v 0 0 0\nf 1 0 1\n").find("'0' names a vertex that is not there (line 2)"),
            std::string::npos);
  EXPECT_NE(fault_of("v 0 0 0\nf -2 1 1\n").find("(line 2)"), std::string::npos);
  EXPECT_NE(fault_of("v 0 0 0\nf 1 x 1\n").find("'x' is not a corner of a face (line 2)"), std::string::npos);
  EXPECT_NE(fault_of("v 0 0 0\nf 99999999999999999999 1 1\n").find("(line 2)"), std::string::npos);
  EXPECT_NE(fault_of("o empty\n").find("holds no points"), std::string::npos);
}

}  // namespace
}  // namespace phiz::test
