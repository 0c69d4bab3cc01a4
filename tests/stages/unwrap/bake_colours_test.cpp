#include <gtest/gtest.h>

#include "stages/geometry/error.h"
#include "stages/unwrap/unwrap.h"
#include "tests/stages/unwrap/uv_samples.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

/// Points on a flat sheet of 20 x 20 mm, facing +z, with a colour by place.
template <class Colour>
PointCloud flat_cloud(int count, const Colour& colour) {
  PointCloud cloud;
  for (int i = 0; i < count; ++i) {
    cloud.positions.emplace_back(static_cast<float>(test::random().uniform(0, 20)),
                                 static_cast<float>(test::random().uniform(0, 20)), 0.0f);
    cloud.normals.emplace_back(Eigen::Vector3f::UnitZ());
    cloud.colours.push_back(colour(cloud.positions.back()));
  }
  return cloud;
}

struct Places {
  std::vector<Eigen::Vector3f> positions, normals;
  int side = 21;
  Places() {
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) positions.emplace_back(x, 20 - y, 0);
    normals.assign(positions.size(), Eigen::Vector3f::UnitZ());
  }
};

TEST(BakeColours, OneColourStaysThatColourSeenOrFilledIn) {
  PointCloud cloud = flat_cloud(3000, [](const auto&) { return std::array<std::uint8_t, 3>{200, 120, 40}; });
  std::erase_if(cloud.positions, [](const auto& p) { return p.x() > 10; });
  cloud.normals.resize(cloud.positions.size());
  cloud.colours.resize(cloud.positions.size());
  const Places places;
  const BakedColours baked = bake_colours(cloud, places.positions, places.normals, 21, 21);
  int filled = 0;
  for (std::size_t i = 0; i < baked.colours.size(); ++i) {
    EXPECT_NEAR(baked.colours[i].x(), linear_from_srgb(200), 1e-5);
    EXPECT_NEAR(baked.colours[i].z(), linear_from_srgb(40), 1e-5);
    filled += baked.mask[i] == 0;
  }
  EXPECT_GT(filled, 100);
  EXPECT_LT(filled, 300);
}

TEST(BakeColours, PointsThatFaceAwayGiveNoColour) {
  PointCloud cloud = flat_cloud(4000, [](const auto&) { return std::array<std::uint8_t, 3>{10, 250, 10}; });
  for (std::size_t i = 0; i < cloud.size(); i += 2) {
    cloud.normals[i] = -Eigen::Vector3f::UnitZ();
    cloud.colours[i] = {250, 10, 10};
  }
  const Places places;
  const BakedColours baked = bake_colours(cloud, places.positions, places.normals, 21, 21);
  for (const Eigen::Vector3f& colour : baked.colours) EXPECT_NEAR(colour.x(), linear_from_srgb(10), 1e-5);
}

TEST(BakeColours, RefusesACloudWithoutColours) {
  PointCloud cloud = flat_cloud(10, [](const auto&) { return std::array<std::uint8_t, 3>{}; });
  cloud.colours.clear();
  const Places places;
  EXPECT_THROW(bake_colours(cloud, places.positions, places.normals, 21, 21), InvalidInput);
}

TEST(BakeColours, TexturesAreSampledAtPixelCentres) {
  const test::UvMesh mesh = test::random_uv_square(3);
  const UvChart chart = make_uv_chart(mesh.uv, mesh.triangles, 1);
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector2d& uv : chart.uv) positions.emplace_back(20 * uv.x(), 20 * uv.y(), 0);
  const UvSurface surface(chart, positions);
  const PointCloud cloud = flat_cloud(60'000, [](const Eigen::Vector3f& p) {
    return std::array<std::uint8_t, 3>{srgb_from_linear(p.x() / 20), srgb_from_linear(p.y() / 20), 0};
  });
  const FloatImage texture = bake_texture(surface, cloud, {16, {}});
  for (int y = 2; y < 14; ++y) {
    for (int x = 2; x < 14; ++x) {
      EXPECT_NEAR(texture.channels.at("R")[y * 16 + x], (x + 0.5) / 16, 0.015);
      EXPECT_NEAR(texture.channels.at("G")[y * 16 + x], 1 - (y + 0.5) / 16, 0.015);
    }
  }
  const Image picture = to_srgb(texture);
  EXPECT_EQ(picture.at(5, 9)[0], srgb_from_linear(texture.channels.at("R")[9 * 16 + 5]));
}

}  // namespace
}  // namespace phiz
