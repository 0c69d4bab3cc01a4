#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tests/formats/scan_samples.h"
#include "tests/support/random.h"

namespace phiz::test {
namespace {

constexpr PlyKind kKinds[] = {PlyKind::ascii, PlyKind::little, PlyKind::big};

void expect_sample(const ScanFile& scan, const ScanSample& sample) {
  EXPECT_EQ(scan.format, "ply");
  EXPECT_EQ(scan.origin, Eigen::Vector3d::Zero());
  EXPECT_EQ(scan.points.positions, sample.positions);
  EXPECT_EQ(scan.points.colours, sample.colours);
  EXPECT_EQ(scan.points.confidences, sample.confidences);
  ASSERT_EQ(scan.points.normals.size(), sample.normals.size());
  for (std::size_t i = 0; i < sample.normals.size(); ++i)
    EXPECT_LT((scan.points.normals[i] - sample.normals[i]).norm(), 1e-6f);
  EXPECT_EQ(scan.triangles, sample.triangles);
}

TEST(ScanPly, GivesTheSameCloudInEachEncodingAndOrderOfProperties) {
  const ScanSample sample = make_sample();
  std::vector<PlyColumn> columns = ply_columns(sample);
  for (int round = 0; round < 20; ++round) {
    for (std::size_t i = columns.size() - 1; i > 0; --i)
      std::swap(columns[i], columns[random().below(i + 1)]);
    const int list_at = static_cast<int>(random().below(columns.size() + 2)) - 1;
    for (const PlyKind kind : kKinds) {
      SCOPED_TRACE(static_cast<int>(kind));
      expect_sample(parse(write_ply_as(kind, columns, sample.triangles, list_at)), sample);
    }
  }
}

TEST(ScanPly, ReadsPositionsOfEachType) {
  std::vector<double> values;
  for (int i = 0; i < 50; ++i) values.push_back(static_cast<double>(random().below(128)));
  for (const char* type : {"char", "uchar", "short", "ushort", "int", "uint", "float", "double", "int8",
                           "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"})
    for (const PlyKind kind : kKinds) {
      SCOPED_TRACE(type);
      const ScanFile scan =
          parse(write_ply_as(kind, {{"z", type, values}, {"x", type, values}, {"y", type, values}}, {}));
      const std::vector<Eigen::Vector3d> positions = true_positions(scan);
      ASSERT_EQ(positions.size(), values.size());
      for (std::size_t i = 0; i < values.size(); ++i)
        EXPECT_EQ(positions[i], Eigen::Vector3d::Constant(values[i]));
    }
}

TEST(ScanPly, UnderstandsCarriageReturns) {
  const ScanSample sample = make_sample();
  const std::string text = write_ply_as(PlyKind::ascii, ply_columns(sample), sample.triangles);
  std::string windows, mac = text;
  for (const char c : text) windows += c == '\n' ? "\r\n" : std::string(1, c);
  std::replace(mac.begin(), mac.end(), '\n', '\r');
  expect_sample(parse(windows), sample);
  expect_sample(parse(mac), sample);
  const std::string binary = write_ply_as(PlyKind::big, ply_columns(sample), sample.triangles);
  const std::size_t body = binary.find("end_header\n") + 11;
  std::string head;
  for (const char c : binary.substr(0, body)) head += c == '\n' ? "\r\n" : std::string(1, c);
  expect_sample(parse(head + binary.substr(body)), sample);
}

TEST(ScanPly, ScalesColoursOfEachType) {
  const std::vector<double> zero = {0, 0}, unit = {0, 1}, byte = {0, 255}, half = {0.25, 1},
                            word = {257, 65535};
  const auto first_red = [&](const char* type, const std::vector<double>& red,
                             const std::vector<double>& other) {
    const ScanFile scan = parse(write_ply_as(PlyKind::little,
                                             {{"x", "float", unit},
                                              {"y", "float", unit},
                                              {"z", "float", unit},
                                              {"diffuse_red", type, red},
                                              {"diffuse_green", type, other},
                                              {"diffuse_blue", type, other}},
                                             {}));
    return std::pair<int, int>(scan.points.colours.at(0)[0], scan.points.colours.at(1)[0]);
  };
  EXPECT_EQ(first_red("uchar", byte, zero), std::pair(0, 255));
  EXPECT_EQ(first_red("float", half, zero), std::pair(64, 255));
  EXPECT_EQ(first_red("double", {10, 255}, zero), std::pair(10, 255));
  EXPECT_EQ(first_red("ushort", word, zero), std::pair(1, 255));
  EXPECT_EQ(first_red("int", {1, 200}, zero), std::pair(1, 200));
}

TEST(ScanPly, FansPolygonsAndTakesEitherNameOfTheList) {
  for (const char* name : {"vertex_indices", "vertex_index"}) {
    const ScanFile scan = parse(
        std::string("ply\nformat ascii 1.0\nelement face 3\nproperty uchar flags\nproperty list uchar int ") +
        name +
        "\nproperty list uchar float texcoord\nelement vertex 5\nproperty float x\nproperty float y\n"
        "property float z\nelement edge 1\nproperty int a\nend_header\n"
        "7 5 0 1 2 3 4 0\n7 2 0 1 2 0.5 0.5\n\n7 3 4 3 2 0\n0 0 0\n1 0 0\n2 1 0\n1 2 0\n0 1 0\n9\n");
    const std::vector<Eigen::Vector3i> expected = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {4, 3, 2}};
    EXPECT_EQ(scan.triangles, expected);
  }
}

TEST(ScanPly, KeepsNotANumberAndInfinity) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\nend_header\n";
  const ScanFile scan = parse(head + "nan 1 2\n-1.#IND inf -inf\n3 4 5\n");
  ASSERT_EQ(scan.points.size(), 3u);
  EXPECT_TRUE(std::isnan(scan.points.positions[0].x()));
  EXPECT_TRUE(std::isnan(scan.points.positions[1].x()));
  EXPECT_EQ(scan.points.positions[1].y(), std::numeric_limits<float>::infinity());
  EXPECT_EQ(true_positions(scan)[2], Eigen::Vector3d(3, 4, 5));
}

TEST(ScanPly, NamesTheLineOfWhatIsNoNumber) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float "
      "z\nend_header\n";
  EXPECT_EQ(fault_of(head + "0 0 0\n1 abc 2\n").substr(0, 31), "'abc' is not a number (line 9) ");
  EXPECT_EQ(fault_of(head + "0 0 0\n1,5 2 2\n"),
            "'1,5' is not a number (line 9) | decimal commas are not understood: export with decimal points");
  EXPECT_EQ(fault_of(head + "0 0 0\n1 2 3 4\n").substr(0, 54),
            "the row has more numbers than the header says (line 9)");
  EXPECT_EQ(fault_of(head + "0 0 0\n10 200\n").substr(0, 27), "the row has no 'z' (line 9)");
}

TEST(ScanPly, TurnsConfidenceAndQualityIntoZeroToOne) {
  const auto confidences = [](const char* name, const std::vector<double>& values) {
    const std::vector<double> zero(values.size(), 0.0);
    return parse(write_ply_as(PlyKind::big,
                              {{"x", "float", zero},
                               {"y", "float", zero},
                               {"z", "float", zero},
                               {name, "float", values}},
                              {}))
        .points.confidences;
  };
  EXPECT_EQ(confidences("confidence", {0.25, 1.0}), (std::vector<float>{0.25f, 1.0f}));
  EXPECT_EQ(confidences("confidence", {2.0, 8.0, -1.0}), (std::vector<float>{0.25f, 1.0f, 0.0f}));
  EXPECT_EQ(confidences("quality", {0.5, 0.0}), (std::vector<float>{0.5f, 0.0f}));
  EXPECT_TRUE(confidences("quality", {0.5, 3.0}).empty()) << "some other measure";
}

TEST(ScanPly, RefusesLyingCountsAtOnce) {
  const std::string vertex = "property float x\nproperty float y\nproperty float z\nend_header\n";
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"})
    for (const char* count : {"4294967295", "18446744073709551615", "150000000"}) {
      const std::string head = std::string("ply\nformat ") + format + " 1.0\nelement vertex " + count + "\n";
      EXPECT_NE(fault_of(head + vertex + "1 2 3\n"), "") << format << " " << count;
    }
  const std::string faces =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty uchar x\nproperty uchar y\nproperty "
      "uchar z\n"
      "element face 1\nproperty list uint int vertex_indices\nend_header\nabc";
  EXPECT_NE(fault_of(faces + "\xFF\xFF\xFF\xFF"), "");
  EXPECT_NE(fault_of(faces + std::string("\3\0\0\0\0\0\0\0\0\0\0\0\1\0\0\0", 16)).find("beyond the 1"),
            std::string::npos);
  const ScanSample sample = make_sample();
  ScanLimits limits;
  limits.max_points = sample.positions.size() - 1;
  const std::string text = write_ply_as(PlyKind::ascii, ply_columns(sample), {});
  EXPECT_NE(fault_of(text, "", limits).find("more than the 41 allowed"), std::string::npos);
}

TEST(ScanPly, SaysWhatIsWrongWithAHeader) {
  const std::string head = "ply\nformat ascii 1.0\n";
  EXPECT_NE(fault_of(head + "element vertex 1\nproperty float x\nproperty float y\nend_header\n0 0\n")
                .find("no x, y and z"),
            std::string::npos);
  EXPECT_NE(fault_of(head + "element vertex 1\nproperty real x\n")
                .find("'real' is no type of a PLY property (line 4)"),
            std::string::npos);
  EXPECT_NE(fault_of(head + "element vertex many\n").find("'many' is not a count of 'vertex' (line 3)"),
            std::string::npos);
  EXPECT_NE(fault_of(head + "element vertex 1\n").find("no end_header (line 4)"), std::string::npos);
  EXPECT_NE(fault_of("ply\nformat middle_endian 1.0\n").find("'middle_endian' is no PLY format (line 2)"),
            std::string::npos);
}

}  // namespace
}  // namespace phiz::test
