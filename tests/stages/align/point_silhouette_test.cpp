#include "stages/align/point_silhouette.h"

#include <gtest/gtest.h>

#include <limits>

#include "stages/align/silhouette_osmesa.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using test::random;

const AffineMatrix kIdentity = AffineMatrix::Identity();

std::vector<Eigen::Vector3f> square_of_points(double side_mm, double spacing_mm) {
  std::vector<Eigen::Vector3f> points;
  for (double y = -side_mm / 2; y <= side_mm / 2; y += spacing_mm)
    for (double x = -side_mm / 2; x <= side_mm / 2; x += spacing_mm) points.emplace_back(x, y, 0.0);
  return points;
}

TEST(PointSilhouette, SetsTheSquareAroundEachPointAndNothingElse) {
  const std::vector<Eigen::Vector3f> points = {
      {0.25f, 0.25f, 3}, {-100.5f, 90, 0}, {500, 0, 0}, {127.9f, 127.9f, 0}};
  const SilhouetteFrame frame;
  Silhouette drawn;
  rasterise_points(points, kIdentity, ViewAxis::kFront, frame, {.size_px = 5}, drawn);
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x) {
      bool expected = false;
      for (const auto& [column, row] : {std::pair(128, 127), std::pair(27, 38), std::pair(255, 0)})
        expected = expected || (std::abs(x - column) <= 2 && std::abs(y - row) <= 2);
      ASSERT_EQ(drawn.covers(x, y), expected) << x << ' ' << y;
    }
}

TEST(PointSilhouette, LeavesOutWhatIsNotFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinity = std::numeric_limits<float>::infinity();
  const std::vector<Eigen::Vector3f> points = {
      {nan, 0, 0}, {0, infinity, 0}, {-infinity, nan, 0}, {3e38f, -3e38f, 0}};
  Silhouette drawn;
  rasterise_points(points, kIdentity, ViewAxis::kFront, SilhouetteFrame{}, {}, drawn);
  EXPECT_EQ(count_pixels(drawn), 0);
}

TEST(PointSilhouette, AgreesWithOsmesa) {
  std::vector<Eigen::Vector3f> points;
  for (int k = 0; k < 2000; ++k)
    points.emplace_back(random().uniform(-90, 90), random().uniform(-90, 90), random().uniform(-90, 90));
  OsmesaSilhouettes osmesa(256);
  const SilhouetteFrame frame{Eigen::Vector3d(1, 2, 3), 0.9, 256};
  for (const ViewAxis axis : kViewAxes)
    for (const int size : {1, 3, 7}) {
      Silhouette drawn;
      rasterise_points(points, kIdentity, axis, frame, {.size_px = size}, drawn);
      const Silhouette reference = osmesa.rasterise_points(points, kIdentity, axis, frame, size);
      // GL rounds to 1/256 pixel, so that one point in 128 may land in the neighbouring column or row.
      EXPECT_LE(count_xor(drawn, reference), count_pixels(reference) / 50) << "size " << size;
    }
}

TEST(PointSilhouette, PointSizeIsTheSmallestWithoutPinholes) {
  const SilhouetteFrame frame;
  for (const auto& [spacing, size] :
       {std::pair(0.9, 1), std::pair(1.7, 3), std::pair(2.9, 3), std::pair(4.7, 5)}) {
    const std::vector<Eigen::Vector3f> points = square_of_points(120, spacing);
    const PointSize found = find_point_size(points, kIdentity, ViewAxis::kFront, frame);
    EXPECT_EQ(found.pixels, size) << spacing;
    EXPECT_LT(found.pinhole_share, 1e-3);
  }
}

TEST(PointSilhouette, PointSizeIsNotMisledByOutliersOrTrueHoles) {
  std::vector<Eigen::Vector3f> points = square_of_points(120, 1.7);
  std::erase_if(points, [](const Eigen::Vector3f& p) { return p.norm() < 15; });
  for (int k = 0; k < 300; ++k)
    points.emplace_back(random().uniform(-120, 120), random().uniform(-120, 120), 0);
  EXPECT_EQ(find_point_size(points, kIdentity, ViewAxis::kFront, SilhouetteFrame{}).pixels, 3);
}

TEST(PointSilhouette, OneSizeForAllViewsIsThatOfTheSparsest) {
  std::vector<Eigen::Vector3f> points;
  for (const Eigen::Vector3f& p : square_of_points(120, 2.9)) points.emplace_back(p.x(), p.y(), 2.1f * p.y());
  int largest = 0;
  for (const ViewAxis axis : kViewAxes)
    largest = std::max(largest, find_point_size(points, kIdentity, axis, SilhouetteFrame{}).pixels);
  EXPECT_EQ(find_point_size(points, kIdentity, SilhouetteFrame{}).pixels, largest);
}

TEST(PointSilhouette, ShrinkingBackLeavesTheOutlineAtThePoints) {
  const std::vector<Eigen::Vector3f> points = square_of_points(120, 2.9);
  const SilhouetteFrame frame;
  Silhouette swollen, shrunk;
  rasterise_points(points, kIdentity, ViewAxis::kFront, frame, {.size_px = 5}, swollen);
  rasterise_points(points, kIdentity, ViewAxis::kFront, frame, {.size_px = 5, .shrink_back = true}, shrunk);
  EXPECT_NEAR(static_cast<double>(count_pixels(swollen)), 123.0 * 123.0, 500);
  EXPECT_NEAR(static_cast<double>(count_pixels(shrunk)), 119.0 * 119.0, 500);
  Silhouette closed = shrunk;
  EXPECT_EQ(fill_enclosed_holes(closed, 1000), 0);
}

TEST(PointSilhouette, WithoutPointsThePictureIsEmpty) {
  Silhouette drawn(128);
  drawn.fill_span(3, 4, 90);
  rasterise_points({}, kIdentity, ViewAxis::kTop, SilhouetteFrame{}, {}, drawn);
  EXPECT_EQ(drawn, Silhouette(256));
  EXPECT_EQ(find_point_size({}, kIdentity, SilhouetteFrame{}).pixels, 1);
}

}  // namespace
}  // namespace phiz
