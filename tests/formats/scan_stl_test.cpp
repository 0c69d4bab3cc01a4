#include <gtest/gtest.h>

#include "tests/formats/scan_samples.h"

namespace phiz::test {
namespace {

void expect_soup(const ScanFile& scan, const ScanSample& sample) {
  EXPECT_EQ(scan.format, "stl");
  ASSERT_EQ(scan.points.size(), 3 * sample.triangles.size());
  ASSERT_EQ(scan.triangles.size(), sample.triangles.size());
  for (std::size_t i = 0; i < sample.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const int idx = scan.triangles[i][k];
      EXPECT_EQ(idx, static_cast<int>(3 * i) + k) << "duplicates stay";
      EXPECT_EQ(scan.points.positions[static_cast<std::size_t>(idx)],
                sample.positions[static_cast<std::size_t>(sample.triangles[i][k])]);
    }
}

TEST(ScanStl, GivesTheSameSoupAsTextAndAsBytes) {
  const ScanSample sample = make_sample();
  expect_soup(parse(write_stl_text(sample)), sample);
  expect_soup(parse(write_stl_binary(sample)), sample);  // though it begins with "solid"
}

TEST(ScanStl, UnderstandsCapitalsAndSeveralSolids) {
  const std::string facet =
      "FACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 0\nVERTEX 1 0 0\nVERTEX 0 1 0\nENDLOOP\nENDFACET\n";
  EXPECT_EQ(
      parse("SOLID A\n" + facet + "ENDSOLID A\nSOLID\n" + facet + facet + "ENDSOLID\n").triangles.size(), 3u);
}

TEST(ScanStl, ReadsBinaryWithBytesBehindTheTriangles) {
  const ScanSample sample = make_sample();
  std::string bytes = write_stl_binary(sample);
  expect_soup(parse(bytes + "made by someone", ".STL"), sample);
}

TEST(ScanStl, SaysWhatIsWrong) {
  std::string bytes = write_stl_binary(make_sample());
  EXPECT_NE(fault_of(bytes.substr(0, bytes.size() - 1), ".stl")
                .find("80 triangles, there are bytes for 79 (byte 80)"),
            std::string::npos);
  bytes.replace(80, 4, "\xFF\xFF\xFF\xFF");
  EXPECT_NE(fault_of(bytes, ".stl").find("4294967295 triangles"), std::string::npos);
  const std::string head = "solid a\nfacet normal 0 0 1\nouter loop\n";
  EXPECT_NE(fault_of(head + "vertex 0 zero 0\n").find("'zero' is not a number (line 4)"), std::string::npos);
  EXPECT_NE(fault_of(head + "vertex 0 0\n").find("z is missing (line 4)"), std::string::npos);
  EXPECT_NE(fault_of(head + "vertex 0 0 0\nendloop\n").find("less than three vertices (line 5)"),
            std::string::npos);
  EXPECT_NE(fault_of("solid a\nvertex 0 0 0\n").find("outside a loop (line 2)"), std::string::npos);
  EXPECT_NE(fault_of("solid a\nfacet normal 0 0 1\n").find("ends within a solid"), std::string::npos);
}

}  // namespace
}  // namespace phiz::test
