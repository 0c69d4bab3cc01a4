#include "formats/head_asset.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>
#include <sstream>

#include "formats/content_seal.h"
#include "formats/glb_chunks.h"
#include "formats/head_asset_document.h"
#include "formats/scan_file.h"
#include "tests/formats/hostile_bytes.h"
#include "tests/support/mesh_zoo.h"

namespace phiz {
namespace {

/// A disk of 100 mm with noise on `level_count` levels.
HeadAsset sample_head(std::size_t level_count, int rings = 4) {
  test::Random& dice = test::random();
  const TriangleMesh disk = test::disk(8, rings);
  HeadAsset head;
  head.template_digest = "0123456789abcdef";
  head.triangles = disk.triangles;
  for (const Eigen::Vector3f& p : disk.positions) {
    head.positions.push_back(100.0f * p + Eigen::Vector3f(0.0f, 12.3456f, static_cast<float>(dice.normal())));
    head.uv.emplace_back(0.5f + 0.5f * p.x(), 0.5f + 0.5f * p.y());
  }
  head.scan_from_head.topRightCorner<3, 1>() << 1.0 / 3.0, -1e-7, 4e5;
  std::set<std::pair<int, int>> edges;
  for (const Eigen::Vector3i& t : disk.triangles) {
    for (int k = 0; k < 3; ++k) edges.emplace(std::minmax(t[k], t[(k + 1) % 3]));
  }
  std::size_t vertices = disk.vertex_count(), edge_count = edges.size(), faces = disk.triangle_count(),
              old = 0;
  for (std::size_t level = 0; level < level_count; ++level) {
    auto& displacements = head.displacements_mm.emplace_back(old, 0.0f);
    auto& confidences = head.confidences.emplace_back();
    if (level > 0) confidences = head.confidences[level - 1];
    while (displacements.size() < vertices) {
      displacements.push_back(static_cast<float>(dice.normal() / std::pow(2.0, static_cast<double>(level))));
      constexpr std::uint8_t kKinds[] = {0, 128, 255};
      confidences.push_back(kKinds[dice.below(3)]);
    }
    old = vertices;
    vertices += edge_count;
    edge_count = 2 * edge_count + 3 * faces;
    faces *= 4;
  }
  return head;
}

std::string write(const HeadAsset& head, const HeadAssetOptions& options = {}) {
  std::ostringstream out;
  write_head_asset(head, options, out);
  return out.str();
}

HeadAsset read(const std::string& bytes) {
  std::istringstream in(bytes);
  return read_head_asset(in);
}

void expect_equal(const HeadAsset& head, const HeadAsset& truth, const HeadAssetOptions& options) {
  EXPECT_EQ(head.template_digest, truth.template_digest);
  EXPECT_EQ(head.triangles, truth.triangles);
  EXPECT_EQ(head.scan_from_head, truth.scan_from_head);
  EXPECT_EQ(head.confidences, truth.confidences);
  ASSERT_EQ(head.positions.size(), truth.positions.size());
  ASSERT_EQ(head.uv.size(), truth.uv.size());
  for (std::size_t i = 0; i < truth.positions.size(); ++i) {
    EXPECT_LE((head.positions[i] - truth.positions[i]).cwiseAbs().maxCoeff(),
              0.5 * options.position_step_mm + 8e-6);
    EXPECT_LE((head.uv[i] - truth.uv[i]).cwiseAbs().maxCoeff(), 0.51f / 65535.0f);
  }
  ASSERT_EQ(head.displacements_mm.size(), truth.displacements_mm.size());
  for (std::size_t level = 0; level < truth.displacements_mm.size(); ++level) {
    ASSERT_EQ(head.displacements_mm[level].size(), truth.displacements_mm[level].size());
    for (std::size_t i = 0; i < truth.displacements_mm[level].size(); ++i) {
      EXPECT_NEAR(head.displacements_mm[level][i], truth.displacements_mm[level][i],
                  0.5 * options.displacement_step_mm + 1e-6);
    }
  }
}

TEST(HeadAsset, KeepsEverythingWithinHalfAStep) {
  for (const HeadAssetOptions& options : {HeadAssetOptions{}, {0.001, 0.0005}, {1.0, 0.3}}) {
    for (std::size_t level_count : {0u, 1u, 4u}) {
      const HeadAsset head = sample_head(level_count);
      expect_equal(read(write(head, options)), head, options);
    }
  }
}

TEST(HeadAsset, WritesTheSameBytesAfterReading) {
  for (const HeadAssetOptions& options : {HeadAssetOptions{}, {0.001, 0.0005}, {1.0, 0.3}}) {
    const std::string bytes = write(sample_head(4), options);
    EXPECT_TRUE(write(read(bytes), options) == bytes);
  }
}

TEST(HeadAsset, AnyReaderSeesTheControlMeshInMetres) {
  const HeadAsset head = sample_head(3);
  const std::string bytes = write(head);
  const ScanFile scan = parse_scan(std::as_bytes(std::span(bytes)), ".glb");
  EXPECT_EQ(scan.triangles, head.triangles);
  ASSERT_EQ(scan.points.size(), head.positions.size());
  for (std::size_t i = 0; i < head.positions.size(); ++i) {
    const Eigen::Vector3d position = 1000.0 * (scan.origin + scan.points.positions[i].cast<double>());
    EXPECT_LE((position - head.positions[i].cast<double>()).cwiseAbs().maxCoeff(), 0.0051);
  }
}

TEST(HeadAsset, ConfidencesMayBeAbsent) {
  HeadAsset head = sample_head(3);
  head.confidences.clear();
  EXPECT_TRUE(read(write(head)).confidences.empty());
}

TEST(HeadAsset, RefusesToWriteWhatIsNoHead) {
  const auto refused = [](auto spoil) {
    HeadAsset head = sample_head(3);
    spoil(head);
    EXPECT_THROW(write(head), FormatError);
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  refused([](HeadAsset& head) { head.positions[1].z() = kNan; });
  refused([](HeadAsset& head) { head.positions[1].z() = 1e9f; });
  refused([](HeadAsset& head) { head.uv[1].x() = kNan; });
  refused([](HeadAsset& head) { head.uv[1].x() = 1.01f; });
  refused([](HeadAsset& head) { head.uv.pop_back(); });
  refused([](HeadAsset& head) { head.triangles[0][1] = -1; });
  refused([](HeadAsset& head) { head.triangles[0][1] = 1000; });
  refused([](HeadAsset& head) { head.triangles.clear(); });
  refused([](HeadAsset& head) { head.displacements_mm[0][0] = kNan; });
  refused([](HeadAsset& head) { head.displacements_mm[2].back() = 1e9f; });
  refused([](HeadAsset& head) { head.displacements_mm[1][0] = 0.5f; });  // belongs to level 0
  refused([](HeadAsset& head) { head.displacements_mm[1].pop_back(); });
  refused([](HeadAsset& head) { head.confidences[2].push_back(0); });
  refused([](HeadAsset& head) { head.confidences[1][0] ^= 1; });
  refused([](HeadAsset& head) { head.confidences.pop_back(); });
  refused([](HeadAsset& head) { head.scan_from_head(2, 2) = kNan; });
  refused([](HeadAsset& head) { head.template_digest = "a\"b"; });
  EXPECT_THROW(write(sample_head(1), {0.0, 0.01}), FormatError);
  EXPECT_THROW(write(sample_head(1), {0.01, kNan}), FormatError);
}

TEST(HeadAsset, EveryPrefixIsRefused) {
  const std::string bytes = write(sample_head(3));
  test::expect_prefixes_refused(bytes, 7, read);
}

TEST(HeadAsset, EveryMutationIsRefused) {
  const std::string bytes = write(sample_head(2));
  test::expect_mutations_survived(bytes, 20000, [&bytes](const std::string& mutated) {
    if (mutated != bytes) {
      EXPECT_THROW(read(mutated), FormatError);
    }
  });
}

/// What someone could have written on purpose: noise under a seal that fits.
TEST(HeadAsset, SurvivesNoiseUnderAGoodSeal) {
  const std::string good = write(sample_head(3, 2));
  const GlbChunks chunks = split_glb(good);
  int survivors = 0;
  for (int i = 0; i < 3000; ++i) {
    const bool in_json = i % 2 == 0;
    const std::string json = in_json ? test::mutate(std::string(chunks.json)) : std::string(chunks.json);
    std::string bytes =
        join_glb(json, in_json ? std::string(chunks.bin) : test::mutate(std::string(chunks.bin)));
    try {
      const std::size_t seal = head_asset_document::find_seal(bytes);
      bytes.replace(seal, 64, digest_without(bytes, seal, 64));
      const HeadAsset head = read(bytes);
      EXPECT_EQ(head.uv.size(), head.positions.size());
      for (const Eigen::Vector3f& p : head.positions) EXPECT_TRUE(p.allFinite());
      for (const auto& level : head.displacements_mm) {
        for (float displacement : level) EXPECT_TRUE(std::isfinite(displacement));
      }
      ++survivors;
    } catch (const FormatError&) {
    }
  }
  EXPECT_GT(survivors, 0) << "the noise never got past the seal";
}

TEST(HeadAsset, ALyingCountIsRefusedBeforeAllocation) {
  const std::string good = write(sample_head(3, 2));
  const GlbChunks chunks = split_glb(good);
  std::string json(chunks.json);
  const std::size_t vertices = sample_head(3, 2).positions.size();
  const std::string count = "\"vertices\":" + std::to_string(vertices);
  for (std::size_t at = json.find(count); at != std::string::npos; at = json.find(count, at + 1)) {
    json.replace(at, count.size(), "\"vertices\":33000000");
  }
  std::string bytes = join_glb(json, chunks.bin);
  const std::size_t seal = head_asset_document::find_seal(bytes);
  bytes.replace(seal, 64, digest_without(bytes, seal, 64));
  EXPECT_THROW(read(bytes), FormatError);
}

std::string read_file(const std::string& name) {
  std::ifstream in(std::string(PHIZ_TEST_FILES) + "/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// The disk that the kept files hold: one level of 0.25 mm, all measured.
void expect_kept_head(const HeadAsset& head) {
  const TriangleMesh disk = test::disk(8, 2);
  EXPECT_EQ(head.template_digest, "0123456789abcdef");
  EXPECT_EQ(head.triangles, disk.triangles);
  ASSERT_EQ(head.positions.size(), disk.positions.size());
  for (std::size_t i = 0; i < disk.positions.size(); ++i)
    EXPECT_LE((head.positions[i] - 100.0f * disk.positions[i]).cwiseAbs().maxCoeff(), 0.0051f);
  ASSERT_EQ(head.displacements_mm.size(), 1u);
  for (const float displacement : head.displacements_mm[0]) EXPECT_NEAR(displacement, 0.25f, 0.0101f);
  for (const std::uint8_t confidence : head.confidences.at(0)) EXPECT_EQ(confidence, 255);
}

TEST(HeadAsset, EveryVersionEverWrittenIsRead) {
  expect_kept_head(read(read_file("head_asset_schema_1.glb")));
  expect_kept_head(read(read_file("head_asset_schema_2.glb")));
}

TEST(HeadAsset, AnyPrefixGivesTheLevelsThatItHoldsWhole) {
  const HeadAsset head = sample_head(4);
  const std::string bytes = write(head);
  const HeadAsset whole = read(bytes);
  for (const HeadAssetPart& part : list_head_asset_parts(bytes)) {
    if (!part.name.starts_with("level ")) continue;
    const std::size_t level = std::stoul(part.name.substr(6));
    const HeadAsset prefix = read_head_asset_prefix(std::string_view(bytes).substr(0, part.end));
    EXPECT_EQ(prefix.positions, whole.positions);
    ASSERT_EQ(prefix.displacements_mm.size(), level + 1);
    EXPECT_EQ(prefix.displacements_mm[level], whole.displacements_mm[level]);
    const HeadAsset shorter = read_head_asset_prefix(std::string_view(bytes).substr(0, part.end - 1));
    EXPECT_EQ(shorter.displacements_mm.size(), level);
  }
  EXPECT_THROW(read_head_asset_prefix(std::string_view(bytes).substr(0, 100)), FormatError);
}

TEST(HeadAsset, APrefixWithADamagedLevelIsRefused) {
  std::string bytes = write(sample_head(3));
  const std::vector<HeadAssetPart> parts = list_head_asset_parts(bytes);
  bytes[parts[2].end - 1] = static_cast<char>(bytes[parts[2].end - 1] ^ 4);
  EXPECT_THROW(read_head_asset_prefix(bytes), FormatError);
}

TEST(HeadAsset, KeepsToleranceAndProvenance) {
  HeadAsset head = sample_head(2);
  head.tolerance_mm = 0.05;
  head.provenance = {{"ingest.cloud.vdb", "abc123"}};
  const HeadAsset copy = read(write(head));
  EXPECT_EQ(copy.tolerance_mm, 0.05);
  EXPECT_EQ(copy.provenance, head.provenance);
}

TEST(HeadAsset, OthersAreShownTheMeshTheyAreGiven) {
  const HeadAsset head = sample_head(2);
  const TriangleMesh shown = test::disk(8, 7);
  HeadAssetOptions options;
  options.shown = &shown;
  options.shown_level = 1;
  options.shown_step_mm = 0.001;
  const std::string bytes = write(head, options);
  const ScanFile scan = parse_scan(std::as_bytes(std::span(bytes)), ".glb");
  EXPECT_EQ(scan.triangles.size(), shown.triangles.size());
  EXPECT_EQ(scan.points.size(), shown.positions.size());
  expect_equal(read(bytes), head, {});
}

}  // namespace
}  // namespace phiz
