#include "stages/publish/raster.h"

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace phiz {
namespace {

using test::random;

SampleBand empty_band(int width, int rows) {
  SampleBand band;
  band.reset(width, 0, rows);
  return band;
}

int count_owned(const SampleBand& band, std::int32_t owner) {
  return static_cast<int>(std::count(band.owner.begin(), band.owner.end(), owner));
}

TEST(Raster, TrianglesOfAFanShareNoSampleAndLeaveNone) {
  for (int k = 0; k < 50; ++k) {
    const Eigen::Vector3f centre(random().uniform(10, 50), random().uniform(10, 50), 0);
    const std::array<Eigen::Vector3f, 4> rim = {Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(60, 0, 0),
                                                Eigen::Vector3f(60, 60, 0), Eigen::Vector3f(0, 60, 0)};
    std::vector<int> covered(64 * 64, 0);
    for (std::size_t i = 0; i < 4; ++i) {
      SampleBand band = empty_band(64, 64);
      draw_triangle({centre, rim[i], rim[(i + 1) % 4]}, 0, band);
      for (std::size_t s = 0; s < covered.size(); ++s) covered[s] += band.owner[s] == 0;
    }
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x)
        ASSERT_EQ(covered[static_cast<std::size_t>(y * 64 + x)], x < 60 && y < 60) << x << ' ' << y;
  }
}

TEST(Raster, BandsAreStripesOfTheWholePicture) {
  const std::array<Eigen::Vector3f, 3> corners = {
      Eigen::Vector3f(-20, -7.3f, 1), Eigen::Vector3f(90, 30.2f, 5), Eigen::Vector3f(13.1f, 80, -3)};
  SampleBand whole = empty_band(64, 64);
  draw_triangle(corners, 7, whole);
  for (int first = 0; first < 64; first += 16) {
    SampleBand band;
    band.reset(64, first, 16);
    draw_triangle(corners, 7, band);
    for (std::size_t s = 0; s < band.owner.size(); ++s) {
      const std::size_t there = static_cast<std::size_t>(first) * 64 + s;
      ASSERT_EQ(band.owner[s], whole.owner[there]);
      ASSERT_EQ(band.depth[s], whole.depth[there]);
    }
  }
  EXPECT_GT(count_owned(whole, 7), 500);
}

TEST(Raster, DepthIsThatOfThePlane) {
  SampleBand band = empty_band(64, 64);
  const auto plane = [](float x, float y) { return 3 + 0.25f * x - 0.5f * y; };
  draw_triangle({Eigen::Vector3f(0, 0, plane(0, 0)), Eigen::Vector3f(64, 0, plane(64, 0)),
                 Eigen::Vector3f(0, 64, plane(0, 64))},
                1, band);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x + y < 63; ++x)
      ASSERT_NEAR(band.depth[static_cast<std::size_t>(y * 64 + x)],
                  plane(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f), 1e-4);
}

TEST(Raster, FarCornersAndNeedlesAreHarmless) {
  SampleBand band = empty_band(64, 64);
  draw_triangle(
      {Eigen::Vector3f(-1e7f, -1e7f, 0), Eigen::Vector3f(1.5e7f, 0, 0), Eigen::Vector3f(0, 1.6e7f, 0)}, 1,
      band);
  EXPECT_EQ(count_owned(band, 1), 64 * 64);
  draw_triangle({Eigen::Vector3f(3, 3, 9), Eigen::Vector3f(40, 40, 9), Eigen::Vector3f(21, 21, 9)}, 2, band);
  EXPECT_EQ(count_owned(band, 2), 0);
}

TEST(Raster, ADiscCoversItsArea) {
  SampleBand band = empty_band(64, 64);
  draw_disc({30.3f, 31.7f, 2}, 20, 4, band);
  EXPECT_NEAR(count_owned(band, 4), 3.14159 * 20 * 20, 30);
  draw_disc({30.3f, 31.7f, 1}, 25, 5, band);  // behind: a rim remains
  EXPECT_NEAR(count_owned(band, 4), 3.14159 * 20 * 20, 30);
  EXPECT_NEAR(count_owned(band, 5), 3.14159 * (25 * 25 - 20 * 20), 60);
}

TEST(Raster, BinsHoldEachPrimitiveInEachBandItTouchesInOrder) {
  std::vector<std::pair<int, int>> rows;
  for (int i = 0; i < 200; ++i) {
    const int first = static_cast<int>(random().below(140)) - 20;
    rows.emplace_back(first, first + static_cast<int>(random().below(40)) - 2);
  }
  const BandBins bins(200, 100, 16, [&](int i) { return rows[static_cast<std::size_t>(i)]; });
  ASSERT_EQ(bins.band_count(), 7);
  for (int band = 0; band < 7; ++band) {
    std::vector<std::int32_t> expected;
    for (int i = 0; i < 200; ++i) {
      const auto [first, last] = rows[static_cast<std::size_t>(i)];
      if (first <= last && first < (band + 1) * 16 && last >= band * 16) expected.push_back(i);
    }
    const auto got = bins.primitives(band);
    EXPECT_EQ(std::vector<std::int32_t>(got.begin(), got.end()), expected) << band;
  }
}

}  // namespace
}  // namespace phiz
