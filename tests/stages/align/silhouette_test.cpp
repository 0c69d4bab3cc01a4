#include "stages/align/silhouette.h"

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace phiz {
namespace {

Silhouette random_silhouette(int width, int height, double share) {
  Silhouette s(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (test::random().uniform() < share) s.fill_span(y, x, x + 1);
  return s;
}

Silhouette rectangle(int x0, int y0, int x1, int y1) {
  Silhouette s(128);
  for (int y = y0; y < y1; ++y) s.fill_span(y, x0, x1);
  return s;
}

void set_pixel(Silhouette& s, int x, int y, bool value) {
  std::uint64_t& word = s.row(y)[static_cast<std::size_t>(x) / 64];
  const std::uint64_t bit = std::uint64_t{1} << (x % 64);
  word = value ? word | bit : word & ~bit;
}

TEST(Silhouette, FillSpanSetsExactlyItsPixels) {
  for (int begin = 0; begin <= 192; begin += 7)
    for (int end = begin; end <= 192; ++end) {
      Silhouette s(192, 1);
      s.fill_span(0, begin, end);
      for (int x = 0; x < 192; ++x) ASSERT_EQ(s.covers(x, 0), begin <= x && x < end) << begin << ' ' << end;
    }
}

TEST(Silhouette, CountsWhatALoopOverPixelsCounts) {
  const Silhouette a = random_silhouette(192, 67, 0.3), b = random_silhouette(192, 67, 0.5);
  const Silhouette mask = random_silhouette(192, 67, 0.7);
  std::int64_t set = 0, differ = 0, masked = 0;
  for (int y = 0; y < 67; ++y)
    for (int x = 0; x < 192; ++x) {
      set += a.covers(x, y);
      differ += a.covers(x, y) != b.covers(x, y);
      masked += a.covers(x, y) != b.covers(x, y) && mask.covers(x, y);
    }
  EXPECT_EQ(count_pixels(a), set);
  EXPECT_EQ(count_xor(a, b), differ);
  EXPECT_EQ(count_xor(a, b, mask), masked);
  EXPECT_EQ(count_xor(a, a), 0);
}

TEST(Silhouette, FrameShowsTheWholeBoxInEveryView) {
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-80, -120, -60), Eigen::Vector3d(90, 140, 130));
  const SilhouetteFrame frame = make_silhouette_frame(box, 256);
  for (const ViewAxis axis : kViewAxes)
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector2d p =
          frame.project(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)), axis);
      EXPECT_GE(p.minCoeff(), 0);
      EXPECT_LE(p.maxCoeff(), 256);
    }
}

TEST(Silhouette, ViewsShowTheAxesTheyName) {
  SilhouetteFrame frame;
  const auto moved = [&](const Eigen::Vector3d& by, ViewAxis axis) {
    return Eigen::Vector2d(frame.project(by, axis) - frame.project(Eigen::Vector3d::Zero(), axis));
  };
  using Eigen::Vector2d, Eigen::Vector3d;
  EXPECT_EQ(moved(Vector3d::UnitX(), ViewAxis::kFront), Vector2d(1, 0));
  EXPECT_EQ(moved(Vector3d::UnitY(), ViewAxis::kFront), Vector2d(0, -1));
  EXPECT_EQ(moved(Vector3d::UnitZ(), ViewAxis::kFront), Vector2d(0, 0));
  EXPECT_EQ(moved(Vector3d::UnitZ(), ViewAxis::kSide), Vector2d(1, 0));
  EXPECT_EQ(moved(Vector3d::UnitY(), ViewAxis::kSide), Vector2d(0, -1));
  EXPECT_EQ(moved(Vector3d::UnitX(), ViewAxis::kTop), Vector2d(1, 0));
  EXPECT_EQ(moved(Vector3d::UnitZ(), ViewAxis::kTop), Vector2d(0, 1));
}

TEST(Silhouette, HalfPlaneMaskSplitsThePictureAtThePlane) {
  SilhouetteFrame frame;  // 256 pixels of 1 mm around the origin
  const Silhouette mask = make_half_plane_mask(Eigen::Vector3d::UnitY(), -28.0, ViewAxis::kFront, frame);
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; x += 17) EXPECT_EQ(mask.covers(x, y), y < 156) << x << ' ' << y;
  const Silhouette other = make_half_plane_mask(-Eigen::Vector3d::UnitY(), 28.0, ViewAxis::kFront, frame);
  EXPECT_EQ(count_xor(mask, other), 256 * 256);
}

TEST(Silhouette, SlantedHalfPlanesShareEveryPixelBetweenThem) {
  SilhouetteFrame frame;
  for (int k = 0; k < 20; ++k) {
    const double angle = test::random().uniform(0, 6.28);
    const Eigen::Vector3d normal(0, std::cos(angle), std::sin(angle));
    const double offset = test::random().uniform(-100, 100);
    const Silhouette here = make_half_plane_mask(normal, offset, ViewAxis::kSide, frame);
    const Silhouette there = make_half_plane_mask(-normal, -offset, ViewAxis::kSide, frame);
    EXPECT_EQ(count_xor(here, there), 256 * 256);
  }
}

TEST(Silhouette, APlaneFacingTheViewerClipsNothing) {
  SilhouetteFrame frame;
  const Silhouette mask = make_half_plane_mask(Eigen::Vector3d::UnitZ(), 1000, ViewAxis::kFront, frame);
  EXPECT_EQ(count_pixels(mask), 256 * 256);
  EXPECT_EQ(count_pixels(make_half_plane_mask(Eigen::Vector3d::UnitX(), 1e9, ViewAxis::kFront, frame)), 0);
  EXPECT_EQ(count_pixels(make_half_plane_mask(Eigen::Vector3d::UnitX(), -1e9, ViewAxis::kFront, frame)),
            256 * 256);
}

TEST(Silhouette, PolygonMaskIsTheSameForBothDirections) {
  std::vector<Eigen::Vector2d> corners = {{10, 10}, {118, 30}, {90, 100.5}, {40, 64.25}};
  const Silhouette there = make_polygon_mask(corners, 128);
  std::reverse(corners.begin(), corners.end());
  EXPECT_EQ(there, make_polygon_mask(corners, 128));
  EXPECT_TRUE(there.covers(60, 50));
  EXPECT_FALSE(there.covers(30, 90));
}

TEST(Silhouette, FillsHolesUpToTheGivenAreaOnly) {
  Silhouette s = rectangle(20, 20, 110, 110);
  set_pixel(s, 64, 40, false);
  set_pixel(s, 63, 41, false);  // touches the first by a corner only: another hole
  for (int y = 60; y < 64; ++y)
    for (int x = 62; x < 67; ++x) set_pixel(s, x, y, false);
  Silhouette small = s;
  EXPECT_EQ(fill_enclosed_holes(small, 1), 2);
  EXPECT_FALSE(small.covers(64, 62));
  EXPECT_EQ(fill_enclosed_holes(small, 19), 0);
  EXPECT_EQ(fill_enclosed_holes(small, 20), 20);
  EXPECT_EQ(small, rectangle(20, 20, 110, 110));
}

TEST(Silhouette, ABayThatReachesTheEdgeIsNoHole) {
  Silhouette s = rectangle(0, 0, 128, 128);
  for (int y = 0; y < 50; ++y) set_pixel(s, 70, y, false);
  const Silhouette before = s;
  EXPECT_EQ(fill_enclosed_holes(s, 10000), 0);
  EXPECT_EQ(s, before);
}

TEST(Silhouette, RemovesSpecksAndKeepsWhatHangsTogetherByCorners) {
  Silhouette s = rectangle(20, 20, 40, 40);
  for (int k = 0; k < 8; ++k) set_pixel(s, 80 + k, 60 + k, true);  // a diagonal of eight pixels
  set_pixel(s, 100, 20, true);
  EXPECT_EQ(remove_specks(s, 8), 1);
  EXPECT_EQ(count_pixels(s), 400 + 8);
  EXPECT_EQ(remove_specks(s, 9), 8);
  EXPECT_EQ(s, rectangle(20, 20, 40, 40));
}

TEST(Silhouette, RegionsMayBendAndBranch) {
  Silhouette s(128);  // a comb whose teeth meet only at the bottom: one region
  for (int tooth = 0; tooth < 20; ++tooth)
    for (int y = 10; y < 60; ++y) set_pixel(s, 10 + 4 * tooth, y, true);
  s.fill_span(60, 10, 10 + 4 * 19 + 1);
  EXPECT_EQ(remove_specks(s, 1000), 0);
  EXPECT_EQ(remove_specks(s, 20 * 50 + 77 + 1), 20 * 50 + 77);
}

TEST(Silhouette, GrowingIsTheSquareAroundEveryPixel) {
  const Silhouette s = random_silhouette(128, 40, 0.01);
  Silhouette grown = s;
  grow(grown, 2);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 128; ++x) {
      bool near = false;
      for (int v = std::max(y - 2, 0); v <= std::min(y + 2, 39); ++v)
        for (int u = std::max(x - 2, 0); u <= std::min(x + 2, 127); ++u) near = near || s.covers(u, v);
      ASSERT_EQ(grown.covers(x, y), near) << x << ' ' << y;
    }
}

TEST(Silhouette, ShrinkingAfterGrowingRestoresASolidShape) {
  Silhouette s = rectangle(30, 40, 90, 80);
  grow(s, 5);
  EXPECT_EQ(s, rectangle(25, 35, 95, 85));
  grow(s, -5);
  EXPECT_EQ(s, rectangle(30, 40, 90, 80));
}

}  // namespace
}  // namespace phiz
