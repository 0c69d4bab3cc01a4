// Each reader against each prefix of a valid file and against 20,000 random changes of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>

#include "formats/error.h"
#include "tests/formats/scan_samples.h"
#include "tests/support/random.h"

namespace phiz::test {
namespace {

struct Format {
  const char* name;
  const char* extension;
  bool is_text;
  std::string (*write)(const ScanSample&);
};

std::ostream& operator<<(std::ostream& out, const Format& format) {
  return out << format.name;
}

template <PlyKind kKind>
std::string ply_of(const ScanSample& sample) {
  return write_ply_as(kKind, ply_columns(sample), sample.triangles, 3);
}

const Format kFormats[] = {
    {"PlyAscii", ".ply", true, ply_of<PlyKind::ascii>},
    {"PlyLittle", ".ply", false, ply_of<PlyKind::little>},
    {"PlyBig", ".ply", false, ply_of<PlyKind::big>},
    {"Obj", ".obj", true, write_obj_text},
    {"StlText", ".stl", true, write_stl_text},
    {"StlBinary", ".stl", false, write_stl_binary},
    {"Off", ".off", true, write_off_text},
    {"Columns", ".xyz", true, [](const ScanSample& s) { return write_columns(s, " "); }},
    {"Pts", ".pts", true,
     [](const ScanSample& s) { return std::to_string(s.positions.size()) + "\n" + write_columns(s, " "); }},
    {"Csv", ".csv", true,
     [](const ScanSample& s) { return "x,y,z,r,g,b,nx,ny,nz\n" + write_columns(s, ","); }},
    {"Glb", ".glb", false, write_glb},
    {"GlbDraco", ".glb", false, write_draco_glb},
    {"DrcMesh", ".drc", false, [](const ScanSample& s) { return write_drc(s, true); }},
    {"DrcCloud", ".drc", false, [](const ScanSample& s) { return write_drc(s, false); }},
};

/// Few points, so that a mutation is likely to matter.
ScanSample small_sample() {
  ScanSample sample = make_sample();
  sample.positions.resize(12);
  sample.normals.resize(12);
  sample.colours.resize(12);
  sample.confidences.resize(12);
  sample.triangles = {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}, {9, 10, 11}, {0, 2, 4}};
  return sample;
}

/// True if the bytes are refused as they should be; otherwise `scan` is what was read.
bool is_refused(const std::string& bytes, const std::string& extension, ScanFile& scan) {
  try {
    scan = parse(bytes, extension);
  } catch (const FormatError& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << "one line";
    EXPECT_FALSE(std::string(error.what()).empty());
    return true;
  }
  return false;
}

void expect_sound(const ScanFile& scan) {
  const std::size_t n = scan.points.size();
  EXPECT_GT(n, 0u);
  EXPECT_TRUE(scan.points.normals.empty() || scan.points.normals.size() == n);
  EXPECT_TRUE(scan.points.colours.empty() || scan.points.colours.size() == n);
  EXPECT_TRUE(scan.points.confidences.empty() || scan.points.confidences.size() == n);
  for (const Eigen::Vector3i& t : scan.triangles)
    EXPECT_TRUE((t.array() >= 0).all() && (t.array() < static_cast<int>(n)).all());
}

std::string mutate(std::string bytes) {
  const std::uint64_t changes = 1 + random().below(4);
  for (std::uint64_t i = 0; i < changes && !bytes.empty(); ++i) {
    const std::size_t at = random().below(bytes.size());
    switch (random().below(7)) {
      case 0:
        bytes[at] = static_cast<char>(random().below(256));
        break;
      case 1:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << random().below(8)));
        break;
      case 2:
        bytes.erase(at, 1 + random().below(16));
        break;
      case 3:
        bytes.insert(at, bytes.substr(random().below(bytes.size()), 1 + random().below(16)));
        break;
      case 4:
        bytes[at] = "0123456789-+.eE \n\t\\/,;#"[random().below(23)];
        break;
      case 5:
        bytes.replace(at, std::min<std::size_t>(4, bytes.size() - at), "\xFF\xFF\xFF\xFF");
        break;
      default:
        bytes.resize(at);
        break;
    }
  }
  return bytes;
}

class ScanHostile : public testing::TestWithParam<Format> {};

TEST_P(ScanHostile, EachPrefixIsRefusedOrAShorterCloud) {
  const std::string whole = GetParam().write(small_sample());
  const std::vector<Eigen::Vector3d> positions = true_positions(parse(whole, GetParam().extension));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    SCOPED_TRACE(size);
    ScanFile scan;
    if (is_refused(whole.substr(0, size), GetParam().extension, scan)) continue;
    const bool only_the_end_is_missing = GetParam().is_text && size + 1 == whole.size();
    const bool has_counts = std::string(GetParam().name) != "Obj" &&
                            std::string(GetParam().name) != "Columns" &&
                            std::string(GetParam().name) != "Csv";
    if (has_counts) {
      EXPECT_TRUE(only_the_end_is_missing || scan.points.size() == positions.size());
    }
    expect_sound(scan);
    const std::vector<Eigen::Vector3d> shorter = true_positions(scan);
    ASSERT_LE(shorter.size(), positions.size());
    const std::size_t complete = whole[size - 1] == '\n' ? shorter.size() : shorter.size() - 1;
    for (std::size_t i = 0; i < complete; ++i) EXPECT_LT((shorter[i] - positions[i]).norm(), 1e-4) << i;
  }
}

TEST_P(ScanHostile, SurvivesTwentyThousandChanges) {
  const std::string whole = GetParam().write(small_sample());
  int read = 0;
  for (int i = 0; i < 20000; ++i) {
    ScanFile scan;
    if (is_refused(mutate(whole), GetParam().extension, scan)) continue;
    ++read;
    expect_sound(scan);
  }
  EXPECT_LT(read, 20000);
}

TEST_P(ScanHostile, SurvivesNoise) {
  for (int i = 0; i < 2000; ++i) {
    std::string noise = i % 2 ? GetParam().write(small_sample()).substr(0, random().below(40)) : "";
    for (std::uint64_t k = random().below(300); k > 0; --k) noise += static_cast<char>(random().below(256));
    ScanFile scan;
    if (!is_refused(noise, GetParam().extension, scan)) expect_sound(scan);
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, ScanHostile, testing::ValuesIn(kFormats),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace phiz::test
