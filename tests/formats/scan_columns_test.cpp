#include <gtest/gtest.h>

#include <cmath>

#include "tests/formats/scan_samples.h"

namespace phiz::test {
namespace {

TEST(ScanColumns, GivesTheSameCloudWithEachSeparator) {
  const ScanSample sample = make_sample();
  for (const char* separator : {" ", "\t", ",", ";", ", ", " ; ", "   "}) {
    SCOPED_TRACE(separator);
    for (const char* head : {"", "# a comment\n\n// another\n", "X,Y,Z,Red,Green,Blue,Nx,Ny,Nz\n"}) {
      const ScanFile scan = parse(head + write_columns(sample, separator), ".csv");
      EXPECT_EQ(scan.format, "text");
      EXPECT_EQ(scan.points.positions, sample.positions);
      EXPECT_EQ(scan.points.colours, sample.colours);
      ASSERT_TRUE(scan.points.has_normals());
      EXPECT_LT((scan.points.normals[7] - sample.normals[7]).norm(), 1e-6f);
    }
  }
}

TEST(ScanColumns, TakesColumnsByTheirNumber) {
  EXPECT_FALSE(parse("1 2 3\n4 5 6\n").points.has_colours());
  EXPECT_FALSE(parse("1 2 3 0.5\n4 5 6 0.7\n").points.has_colours());  // intensity
  const ScanFile coloured = parse("1 2 3 255 128 0\n4 5 6 1 2 3\n");
  EXPECT_EQ(coloured.points.colours.at(0), (std::array<std::uint8_t, 3>{255, 128, 0}));
  EXPECT_FALSE(coloured.points.has_normals());
  const ScanFile oriented = parse("1 2 3 0 0.6 -0.8\n4 5 6 1 0 0\n");
  EXPECT_FALSE(oriented.points.has_colours());
  EXPECT_EQ(oriented.points.normals.at(1), Eigen::Vector3f(1, 0, 0));
  const ScanFile leica = parse("1 2 3 -1200 255 0 7\n4 5 6 900 1 2 3\n");
  EXPECT_EQ(leica.points.colours.at(0), (std::array<std::uint8_t, 3>{255, 0, 7}));
  const ScanFile both = parse("1 2 3 0 0.6 -0.8 10 20 30\n4 5 6 1 0 0 40 50 60\n");
  EXPECT_EQ(both.points.colours.at(1), (std::array<std::uint8_t, 3>{40, 50, 60}));
  EXPECT_TRUE(both.points.has_normals());
  EXPECT_FALSE(parse("1 2 3 -4 5 6\n4 5 6 7 8 9\n").points.has_colours()) << "negative is no colour";
}

TEST(ScanColumns, TakesColumnsByTheirNames) {
  const ScanFile scan =
      parse("\"Time\";\"Z [mm]\";\"X [mm]\";\"Y [mm]\";\"Confidence\"\n0;3;1;2;0.5\n9;6;4;5;0.25\n", ".csv");
  EXPECT_EQ(true_positions(scan).at(1), Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(scan.points.confidences, (std::vector<float>{0.5f, 0.25f}));
  const ScanFile commented = parse("//Z Y X\n3 2 1\n6 5 4\n", ".asc");
  EXPECT_EQ(true_positions(commented).at(0), Eigen::Vector3d(1, 2, 3));
}

TEST(ScanColumns, CountsThePointsOfPts) {
  EXPECT_EQ(parse("2\n1 2 3\n4 5 6\n", ".pts").points.size(), 2u);
  EXPECT_EQ(parse("1\n1 2 3\n2\n4 5 6\n7 8 9\n", ".pts").points.size(), 3u);
  EXPECT_NE(fault_of("3\n1 2 3\n4 5 6\n", ".pts").find("counts 3 points, there are 2"), std::string::npos);
  EXPECT_NE(fault_of("1\n1 2 3\n4 5 6\n", ".pts").find("more points than the file counts (line 3)"),
            std::string::npos);
  EXPECT_NE(fault_of("4000000000\n1 2 3\n", ".pts").find("counts 4000000000 points"), std::string::npos);
}

TEST(ScanColumns, KeepsNotANumberAndEmptyCells) {
  const ScanFile scan = parse("1,nan,3\n4,,6\n7,8,9,\n");
  ASSERT_EQ(scan.points.size(), 3u);
  EXPECT_TRUE(std::isnan(scan.points.positions[0].y()));
  EXPECT_TRUE(std::isnan(scan.points.positions[1].y()));
  EXPECT_EQ(true_positions(scan)[2], Eigen::Vector3d(7, 8, 9));
}

TEST(ScanColumns, NamesTheLineOfWhatIsWrong) {
  EXPECT_NE(fault_of("1 2 3\n4 abc 6\n").find("'abc' is not a number (line 2)"), std::string::npos);
  EXPECT_NE(fault_of("1 abc 3\n").find("'abc' is not a number (line 1)"), std::string::npos);
  EXPECT_NE(fault_of("x y z\n1 2 3\nx y z\n", ".xyz").find("'x' is not a number (line 3)"),
            std::string::npos);
  EXPECT_NE(fault_of("1 2 3\n4 5\n").find("has 2 columns (line 2)"), std::string::npos);
  EXPECT_NE(fault_of("1 2 3\n4 5 6 7\n").find("has 4 columns, those above 3 (line 2)"), std::string::npos);
  for (const char* text : {"1,5 2,5 3,5\n", "1,5;2,5;3,5\n", "1,5\t2,5\t3,5\n"})
    EXPECT_NE(fault_of(text).find("decimal commas"), std::string::npos) << text;
  EXPECT_NE(fault_of("# nothing\n", ".xyz").find("holds no points"), std::string::npos);
  EXPECT_NE(fault_of(std::string("\xFF\xFE") + "1\0 \0"), "");
}

}  // namespace
}  // namespace phiz::test
