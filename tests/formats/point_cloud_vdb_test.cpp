#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <numeric>
#include <sstream>

#include "formats/content_seal.h"
#include "formats/point_cloud.h"
#include "tests/formats/hostile_bytes.h"

namespace phiz {
namespace {

constexpr double kStepMm = 2.0 / 65535.0;

PointCloud sample_cloud(int count, double radius_mm = 100.0) {
  test::Random& dice = test::random();
  PointCloud cloud;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d ray = Eigen::Vector3d(dice.normal(), dice.normal(), dice.normal()).normalized();
    cloud.positions.push_back((radius_mm * ray).cast<float>());
    cloud.normals.push_back(ray.cast<float>());
    cloud.colours.push_back({static_cast<std::uint8_t>(dice.below(256)),
                             static_cast<std::uint8_t>(dice.below(256)), static_cast<std::uint8_t>(i % 256)});
    cloud.confidences.push_back(static_cast<float>(dice.uniform()));
  }
  return cloud;
}

std::string write(const PointCloud& cloud) {
  std::ostringstream out;
  write_vdb(cloud, out);
  return out.str();
}

PointCloud read(const std::string& bytes) {
  std::istringstream in(bytes);
  return read_vdb_points(in);
}

PointCloud reordered(const PointCloud& cloud, const std::vector<std::size_t>& order) {
  PointCloud copy;
  for (std::size_t i : order) {
    copy.positions.push_back(cloud.positions[i]);
    if (cloud.has_normals()) copy.normals.push_back(cloud.normals[i]);
    if (cloud.has_colours()) copy.colours.push_back(cloud.colours[i]);
    if (cloud.has_confidences()) copy.confidences.push_back(cloud.confidences[i]);
  }
  return copy;
}

std::vector<std::size_t> order_by_position(const PointCloud& cloud) {
  std::vector<std::size_t> order(cloud.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&cloud](std::size_t a, std::size_t b) {
    const Eigen::Vector3f &p = cloud.positions[a], &q = cloud.positions[b];
    return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
  });
  return order;
}

TEST(PointCloudVdb, KeepsEveryPointWithinHalfAStep) {
  const PointCloud truth = sample_cloud(2000);
  const PointCloud copy = read(write(truth));
  ASSERT_EQ(copy.size(), truth.size());
  std::vector<std::size_t> nearest(truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const auto distance = [&](const Eigen::Vector3f& p) { return (p - truth.positions[i]).squaredNorm(); };
    const auto closest =
        std::min_element(copy.positions.begin(), copy.positions.end(),
                         [&](const auto& p, const auto& q) { return distance(p) < distance(q); });
    nearest[i] = static_cast<std::size_t>(closest - copy.positions.begin());
  }
  const PointCloud& a = truth;
  const PointCloud b = reordered(copy, nearest);
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_LE((a.positions[i] - b.positions[i]).cwiseAbs().maxCoeff(), 0.5 * kStepMm + 8e-6);
    EXPECT_LE((a.normals[i] - b.normals[i]).cwiseAbs().maxCoeff(), 0.51f / 16384.0f);
    EXPECT_NEAR(b.normals[i].norm(), 1.0f, 1e-4f);
    EXPECT_EQ(a.colours[i], b.colours[i]);
    EXPECT_NEAR(a.confidences[i], b.confidences[i], 0.51f / 65535.0f);
  }
}

TEST(PointCloudVdb, EveryColourAndTheEndsOfConfidenceAreExact) {
  PointCloud cloud;
  for (int i = 0; i < 256; ++i) {
    cloud.positions.emplace_back(static_cast<float>(i), 0.0f, 0.0f);
    cloud.colours.push_back({static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(255 - i), 7});
    cloud.confidences.push_back(i % 2 == 0 ? 0.0f : 1.0f);
  }
  const PointCloud copy = read(write(cloud));
  const PointCloud sorted = reordered(copy, order_by_position(copy));
  EXPECT_FALSE(copy.has_normals());
  EXPECT_EQ(sorted.colours, cloud.colours);
  EXPECT_EQ(sorted.confidences, cloud.confidences);
}

TEST(PointCloudVdb, WritesTheSameBytesAfterReading) {
  for (double radius_mm : {1e-3, 3.0, 150.0, 400.0, 1000.0, 3e5}) {
    const std::string bytes = write(sample_cloud(radius_mm > 1000.0 ? 50 : 1000, radius_mm));
    EXPECT_TRUE(write(read(bytes)) == bytes) << radius_mm;
  }
}

TEST(PointCloudVdb, PointsOnTheBordersOfVoxelsHaveOneHome) {
  PointCloud cloud;
  for (int i = -40; i < 40; ++i) {
    cloud.positions.emplace_back(static_cast<float>(i), static_cast<float>(-i), 1.0f);
    cloud.positions.emplace_back(std::nextafter(static_cast<float>(i), 99.0f), static_cast<float>(i), -1.0f);
  }
  const std::string bytes = write(cloud);
  const PointCloud copy = read(bytes);
  EXPECT_EQ(copy.size(), cloud.size());
  EXPECT_TRUE(write(copy) == bytes);
}

TEST(PointCloudVdb, BytesDependOnTheSetOfPointsAlone) {
  PointCloud cloud = sample_cloud(5000, 20.0);
  for (int i = 0; i < 50; ++i) cloud.positions[i] = cloud.positions[0];  // same place, other attributes
  const std::string bytes = write(cloud);
  std::vector<std::size_t> order(cloud.size());
  std::iota(order.begin(), order.end(), 0u);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[test::random().below(i)]);
  EXPECT_TRUE(write(reordered(cloud, order)) == bytes);
  for (std::size_t threads : {1u, 2u, 7u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    EXPECT_TRUE(write(cloud) == bytes) << threads;
  }
  cloud.colours[17][1] ^= 1;
  EXPECT_FALSE(write(cloud).substr(0, 57) == bytes.substr(0, 57)) << "the UUID is that of another content";
}

TEST(PointCloudVdb, AnEmptyCloudIsACloud) {
  EXPECT_EQ(read(write(PointCloud{})).size(), 0u);
}

TEST(PointCloudVdb, RefusesToWriteWhatIsNoCloud) {
  const auto refused = [](auto spoil) {
    PointCloud cloud = sample_cloud(10);
    spoil(cloud);
    EXPECT_THROW(write(cloud), FormatError);
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  refused([](PointCloud& cloud) { cloud.positions[3].y() = kNan; });
  refused([](PointCloud& cloud) { cloud.positions[3].y() = 2e6f; });
  refused([](PointCloud& cloud) { cloud.normals[9].z() = kNan; });
  refused([](PointCloud& cloud) { cloud.normals[9].z() = 3.0f; });
  refused([](PointCloud& cloud) { cloud.confidences[0] = kNan; });
  refused([](PointCloud& cloud) { cloud.confidences[0] = 1.5f; });
  refused([](PointCloud& cloud) { cloud.normals.pop_back(); });
  refused([](PointCloud& cloud) { cloud.colours.pop_back(); });
  refused([](PointCloud& cloud) { cloud.confidences.pop_back(); });
}

TEST(PointCloudVdb, DamageIsSeenBeforeOpenVdbSeesTheFile) {
  const std::string bytes = write(sample_cloud(500, 10.0));
  test::expect_prefixes_refused(bytes, 97, read);
  test::expect_mutations_survived(bytes, 800, [&bytes](const std::string& mutated) {
    const bool disguised = mutated.compare(21, 9, bytes, 21, 9) != 0;  // no longer bears our mark
    if (mutated != bytes && !disguised) {
      EXPECT_THROW(check_vdb_seal(mutated), FormatError);
      read(mutated);
    }
  });
}

TEST(PointCloudVdb, RefusesWhatIsNoVdb) {
  EXPECT_THROW(read(""), FormatError);
  EXPECT_THROW(read("ply\nformat ascii 1.0\n"), FormatError);
}

}  // namespace
}  // namespace phiz
