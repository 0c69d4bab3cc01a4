#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "formats/content_seal.h"
#include "formats/distance_field.h"
#include "tests/formats/hostile_bytes.h"

namespace phiz {
namespace {

/// A band about a sphere of 12 mm.
DistanceField sample_field() {
  DistanceField field;
  field.voxel_mm = 0.7;
  field.truncation_mm = 2.1;
  field.origin_mm = {0.1, -200.0 / 3.0, 31.0};
  for (int x = -22; x <= 22; ++x) {
    for (int y = -22; y <= 22; ++y) {
      for (int z = -22; z <= 22; ++z) {
        const double distance = field.voxel_mm * Eigen::Vector3d(x, y, z).norm() - 12.0;
        if (std::abs(distance) > field.truncation_mm || (x > 5 && y > 5)) continue;  // with a hole
        field.coordinates.emplace_back(x, y, z);
        field.distances_mm.push_back(static_cast<float>(distance));
        field.confidences.push_back(static_cast<float>(test::random().uniform()));
      }
    }
  }
  return field;
}

std::string write(const DistanceField& field) {
  std::ostringstream out;
  write_vdb(field, out);
  return out.str();
}

DistanceField read(const std::string& bytes) {
  std::istringstream in(bytes);
  return read_vdb_distance_field(in);
}

TEST(DistanceFieldVdb, ReadsExactlyWhatItWrote) {
  const DistanceField field = sample_field();
  const DistanceField copy = read(write(field));
  EXPECT_EQ(copy.voxel_mm, field.voxel_mm);
  EXPECT_EQ(copy.truncation_mm, field.truncation_mm);
  EXPECT_EQ(copy.origin_mm, field.origin_mm);
  EXPECT_EQ(copy.coordinates, field.coordinates);
  EXPECT_EQ(copy.distances_mm, field.distances_mm);
  EXPECT_EQ(copy.confidences, field.confidences);
}

TEST(DistanceFieldVdb, SameFieldSameBytesAtAnyThreadCount) {
  const DistanceField field = sample_field();
  const std::string bytes = write(field);
  EXPECT_TRUE(write(read(bytes)) == bytes);
  for (std::size_t threads : {1u, 2u, 5u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    EXPECT_TRUE(write(field) == bytes) << threads;
  }
}

TEST(DistanceFieldVdb, AnEmptyFieldIsAField) {
  EXPECT_TRUE(read(write(DistanceField{})).coordinates.empty());
}

TEST(DistanceFieldVdb, RefusesToWriteWhatIsNoField) {
  const auto refused = [](auto spoil) {
    DistanceField field = sample_field();
    spoil(field);
    EXPECT_THROW(write(field), FormatError);
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  refused([](DistanceField& field) { field.distances_mm[7] = kNan; });
  refused([](DistanceField& field) { field.distances_mm[7] = 2.2f; });
  refused([](DistanceField& field) { field.confidences[7] = kNan; });
  refused([](DistanceField& field) { field.confidences[7] = -0.1f; });
  refused([](DistanceField& field) { field.confidences.pop_back(); });
  refused([](DistanceField& field) { field.distances_mm.pop_back(); });
  refused([](DistanceField& field) { std::swap(field.coordinates[3], field.coordinates[4]); });
  refused([](DistanceField& field) { field.coordinates[3] = field.coordinates[4]; });
  refused([](DistanceField& field) { field.coordinates.back().x() = 1 << 21; });
  refused([](DistanceField& field) { field.voxel_mm = 0.0; });
  refused([](DistanceField& field) { field.origin_mm.x() = kNan; });
}

TEST(DistanceFieldVdb, DamageIsSeenBeforeOpenVdbSeesTheFile) {
  const std::string bytes = write(sample_field());
  test::expect_prefixes_refused(bytes, 997, read);
  test::expect_mutations_survived(bytes, 300, [&bytes](const std::string& mutated) {
    const bool disguised = mutated.compare(21, 9, bytes, 21, 9) != 0;  // no longer bears our mark
    if (mutated != bytes && !disguised) {
      EXPECT_THROW(read(mutated), FormatError);
    }
  });
}

}  // namespace
}  // namespace phiz
