#include "stages/publish/stage_views.h"

#include <gtest/gtest.h>

#include <cmath>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "tests/support/mesh_zoo.h"

namespace phiz {
namespace {

constexpr float kRadius = 50;

TriangleMesh ball() {
  TriangleMesh mesh = test::icosphere(4);
  mesh.normals = mesh.positions;
  for (Eigen::Vector3f& position : mesh.positions) position *= kRadius;
  return mesh;
}

/// The vertices of the ball, moved outwards.
PointCloud cloud_about(const TriangleMesh& mesh, float offset_mm) {
  PointCloud cloud;
  cloud.positions = mesh.positions;
  cloud.normals = mesh.normals;
  cloud.confidences.assign(mesh.vertex_count(), 1.0f);
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud.positions[i] += offset_mm * cloud.normals[i];
  return cloud;
}

SheetOptions small_sheet() {
  SheetOptions options;
  options.width = 60;
  options.height = 70;
  return options;
}

HeatMap distance_map(std::vector<float> values) {
  return {std::move(values), 0, 1, ColourMap::kSequential, "mm"};
}

TEST(StageViews, HeatOfASurfaceAgainstItselfIsAllAtTheLowEnd) {
  const TriangleMesh mesh = ball();
  const PointCloud cloud = cloud_about(mesh, 0);
  const std::vector<float> distances = compute_distances(cloud, mesh, 2);
  for (const float distance : distances) ASSERT_LT(distance, 1e-4f);
  SheetRow row;
  row.cloud = &cloud;
  const std::vector<SheetColumn> columns = make_round_columns(cloud);
  row.heat = distance_map(distances);
  const Image drawn = draw_sheet({row}, columns, small_sheet());
  row.heat = distance_map(std::vector<float>(cloud.size(), 0.0f));
  const Image none = draw_sheet({row}, columns, small_sheet());
  ASSERT_EQ(drawn.pixels.size(), none.pixels.size());
  for (std::size_t i = 0; i < drawn.pixels.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c)
      ASSERT_NEAR(drawn.pixels[i][c], none.pixels[i][c], 1) << "pixel " << i;
  }
}

TEST(StageViews, DistancesAreThoseToTheSurfaceUpToTheMost) {
  const TriangleMesh mesh = ball();
  for (const float distance : compute_distances(cloud_about(mesh, 1.5f), mesh, 2)) {
    ASSERT_NEAR(distance, 1.5f, 0.01f);
  }
  PointCloud cloud = cloud_about(mesh, 7);
  cloud.positions[0].x() = std::nanf("");
  const std::vector<float> distances = compute_distances(cloud, mesh, 2);
  EXPECT_TRUE(std::isnan(distances[0]));
  for (std::size_t i = 1; i < distances.size(); ++i) ASSERT_EQ(distances[i], 2);
}

TEST(StageViews, OffsetsAreNoneWhereTheSurfaceIsTheScanAndNoNumberWhereNothingWasScanned) {
  const TriangleMesh mesh = ball();
  PointCloud cloud = cloud_about(mesh, 0);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (cloud.positions[i].y() < 0) continue;
    cloud.positions[kept] = cloud.positions[i];
    cloud.normals[kept++] = cloud.normals[i];
  }
  cloud.positions.resize(kept);
  cloud.normals.resize(kept);
  cloud.confidences.resize(kept);
  const std::vector<float> offsets = compute_offsets(mesh, ScanSurface(cloud), 2);
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    const float y = mesh.positions[i].y();
    if (y > 10) {
      ASSERT_LT(offsets[i], 0.1f) << "at height " << y;
    }
    if (y < -25) {
      ASSERT_TRUE(std::isnan(offsets[i])) << "at height " << y;
    }
  }
}

TEST(StageViews, SheetsAreTheSameAtAnyThreadCount) {
  const TriangleMesh mesh = ball();
  const PointCloud cloud = cloud_about(mesh, 0.3f);
  const auto draw = [&](int threads) {
    Image sheet;
    with_threads(threads, [&] {
      SheetRow scan, head;
      scan.cloud = &cloud;
      scan.heat = distance_map(compute_distances(cloud, mesh, 2));
      head.mesh = &mesh;
      head.heat = distance_map(compute_offsets(mesh, ScanSurface(cloud), 2));
      sheet = draw_sheet({scan, head}, make_round_columns(cloud), small_sheet());
    });
    return sheet;
  };
  const Image one = draw(1), two = draw(2);
  EXPECT_EQ(one.width, two.width);
  EXPECT_EQ(one.pixels, two.pixels);
}

TEST(StageViews, RowsAreFramedAlike) {
  const TriangleMesh mesh = ball();
  const PointCloud cloud = cloud_about(mesh, 0);
  SheetRow plain, measured;
  plain.mesh = measured.mesh = &mesh;
  plain.light = measured.light = Light::kNone;
  measured.heat = distance_map(std::vector<float>(mesh.vertex_count(), 1.0f));
  const Image one = draw_sheet({plain}, make_round_columns(cloud), small_sheet());
  const Image both = draw_sheet({plain, measured}, make_round_columns(cloud), small_sheet());
  const auto is_paper = [](const std::array<std::uint8_t, 3>& colour) {
    return *std::min_element(colour.begin(), colour.end()) >= 250;
  };
  const int first = 8, second = both.height / 2 + 4, right = 4 * (60 + 8);
  ASSERT_LE(one.height, second);
  for (int y = 0; y < 70; ++y) {
    for (int x = 0; x < right; ++x) {
      ASSERT_EQ(is_paper(both.at(x, first + y)), is_paper(both.at(x, second + y))) << x << ' ' << y;
    }
  }
}

TEST(StageViews, AStripIsSplitIntoItsPictures) {
  Image strip;
  strip.width = 12;
  strip.height = 4;
  strip.pixels.assign(48, {0, 0, 0});
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 12; ++x) strip.at(x, y) = {static_cast<std::uint8_t>(100 * (x / 4)), 0, 0};
  }
  const std::vector<Image> pictures = split_strip(strip, 3, 2);
  ASSERT_EQ(pictures.size(), 3u);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(pictures[k].width, 2);
    EXPECT_EQ(pictures[k].height, 2);
    for (const auto& pixel : pictures[k].pixels) EXPECT_EQ(pixel[0], 100 * k);
  }
  EXPECT_THROW(split_strip(Image{}, 3, 2), InvalidInput);
}

TEST(StageViews, ACloudWithoutPointsIsRefused) {
  EXPECT_THROW(make_round_columns({}), InvalidInput);
}

}  // namespace
}  // namespace phiz
