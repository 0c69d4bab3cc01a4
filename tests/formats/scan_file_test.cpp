#include "formats/scan_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "formats/error.h"
#include "formats/gltf.h"
#include "formats/triangle_mesh.h"
#include "tests/formats/scan_samples.h"
#include "tests/support/data_folder.h"
#include "tests/support/random.h"
#include "tests/support/temp_folder.h"

namespace phiz::test {
namespace {

std::string fault_of_file(const std::filesystem::path& path) {
  try {
    read_scan_file(path);
  } catch (const FormatError& error) {
    return error.what();
  }
  return {};
}

TEST(ScanFile, IsRecognisedByContentWhateverItsName) {
  const ScanSample sample = make_sample();
  const std::pair<std::string, std::string> files[] = {
      {write_ply_as(PlyKind::big, ply_columns(sample), {}), "ply"},
      {write_obj_text(sample), "obj"},
      {write_stl_text(sample), "stl"},
      {write_stl_binary(sample), "stl"},
      {write_off_text(sample), "off"},
      {write_columns(sample, ";"), "text"},
      {write_glb(sample), "glb"},
      {write_drc(sample, true), "drc"}};
  for (const auto& [bytes, format] : files)
    for (const char* extension : {"", ".scan", ".PLY", ".txt"})
      EXPECT_EQ(parse(bytes, extension).format, format) << extension;
}

TEST(ScanFile, SaysWhatAFileIsThatIsNone) {
  EXPECT_NE(fault_of("").find("is empty (byte 0)"), std::string::npos);
  EXPECT_NE(fault_of("hello world").find("is no format phiz knows (byte 0)"), std::string::npos);
  EXPECT_NE(fault_of("hello world", ".ply").find("does not begin with 'ply' (byte 0)"), std::string::npos);
  EXPECT_NE(fault_of("\x1F\x8B\x08", ".ply")
                .find("is gzip data, not a scan phiz can read (byte 0) | unpack it first"),
            std::string::npos);
  EXPECT_NE(fault_of("hello", ".glb").find("does not begin like a .glb file"), std::string::npos);
}

TEST(ScanFile, NamesThePathAndTheCause) {
  const TempFolder folder;
  std::ofstream(folder / "empty.ply");
  std::ofstream(folder / "bad.xyz") << "1 2 3\n4 abc 6\n";
  const std::string root = folder.path().string();
  EXPECT_EQ(fault_of_file(folder / "none.ply"), root + "/none.ply: no such file");
  EXPECT_EQ(fault_of_file(folder.path()), root + ": is a directory, not a scan");
  EXPECT_EQ(fault_of_file(folder / "empty.ply"), root + "/empty.ply: is empty (byte 0)");
  EXPECT_EQ(fault_of_file(folder / "bad.xyz"), root + "/bad.xyz: 'abc' is not a number (line 2)");
}

TEST(ScanFile, ReadsBackTheMeshesPhizWrites) {
  const ScanSample sample = make_sample();
  const TriangleMesh mesh{sample.positions, sample.triangles, sample.normals, {}, sample.colours};
  const auto read_back = [&](void (*write)(const TriangleMesh&, std::ostream&), double scale,
                             double tolerance) {
    std::ostringstream out;
    write(mesh, out);
    const ScanFile scan = parse(out.str());
    EXPECT_EQ(scan.triangles, sample.triangles);
    EXPECT_EQ(scan.points.colours, sample.colours);
    const std::vector<Eigen::Vector3d> positions = true_positions(scan);
    ASSERT_EQ(positions.size(), sample.positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i)
      EXPECT_LT((positions[i] * scale - sample.positions[i].cast<double>()).norm(), tolerance);
  };
  read_back(phiz::write_ply, 1.0, 1e-9);
  read_back(phiz::write_obj, 1.0, 1e-5);
  read_back(phiz::write_glb, 1000.0, 1e-4);  // glTF is in metres
  read_back(phiz::write_drc, 1.0, 0.01);
}

TEST(ScanFile, KeepsTheNumbersOfAScanNearZero) {
  const ScanSample sample = make_sample();
  EXPECT_EQ(parse(write_columns(sample, " ")).origin, Eigen::Vector3d::Zero());
}

TEST(ScanFile, KeepsThePrecisionOfAScanFarFromZero) {
  const Eigen::Vector3d offset(4512345.0, -5403210.0, 300.0);
  std::string text = "1e30 0 0\n";  // one wild point in front
  std::vector<Eigen::Vector3d> positions;
  for (int i = 0; i < 6000; ++i) {
    const Eigen::Vector3d step(random().uniform(-0.1, 0.1), random().uniform(-0.1, 0.1),
                               random().uniform(-0.1, 0.1));
    positions.push_back(offset + step);
    text += std::to_string(positions.back().x()) + " " + std::to_string(positions.back().y()) + " " +
            std::to_string(positions.back().z()) + "\n";
  }
  const std::vector<Eigen::Vector3d> read = true_positions(parse(text));
  ASSERT_EQ(read.size(), 6001u);
  for (std::size_t i = 0; i < positions.size(); ++i) EXPECT_LT((read[i + 1] - positions[i]).norm(), 2e-6);
}

TEST(ScanFile, DoesNotDependOnWhereItIsReadFrom) {
  const TempFolder folder;
  const std::string bytes = write_ply_as(PlyKind::little, ply_columns(make_sample()), {});
  std::ofstream(folder / "a.ply", std::ios::binary) << bytes;
  EXPECT_EQ(read_scan_file(folder / "a.ply").points.positions, parse(bytes).points.positions);
}

TEST(ScanFile, ReadsTheSharedScans) {
  PHIZ_SKIP_WITHOUT_DATA();
  const std::filesystem::path scans = phiz_data_folder() / "scans";
  for (const char* name : {"dev04.ply", "dev05.obj", "dev06.stl"})
    if (!std::filesystem::exists(scans / name)) GTEST_SKIP() << "no " << name << " among the test scans";
  const ScanFile ascii = read_scan_file(scans / "dev04.ply");
  EXPECT_EQ(ascii.points.size(), 300000u);
  EXPECT_EQ(ascii.points.positions[0], Eigen::Vector3f(18.4177f, -6.4518f, 112.7589f));
  const ScanFile soup = read_scan_file(scans / "dev05.obj");
  EXPECT_EQ(soup.points.size(), 130398u);
  EXPECT_EQ(soup.triangles.size(), 234917u);
  EXPECT_EQ(read_scan_file(scans / "dev06.stl").triangles.size(), 106973u);
}

}  // namespace
}  // namespace phiz::test
