#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "tests/stages/fit/fit_samples.h"

namespace phiz {
namespace {

using test::generic_head;

const ScanSurface& generic_scan() {
  static const ScanSurface scan(test::sample_surface(generic_head().positions, 40'000));
  return scan;
}

std::vector<int> vertices_in(const char* box) {
  std::vector<int> vertices;
  for (std::size_t v = 0; v < generic_head().positions.size(); ++v)
    if (generic_head().annotations.boxes.at(box).contains(generic_head().positions[v]))
      vertices.push_back(static_cast<int>(v));
  return vertices;
}

/// The generic head with one feature shifted, its surroundings following.
ControlPositions displace_feature(const char* box, const Eigen::Vector3d& shift_mm) {
  ControlPositions moved = generic_head().positions;
  const auto& bounds = generic_head().annotations.boxes.at(box);
  for (auto& p : moved) p += std::exp(-bounds.exteriorDistance(p) / 12) * shift_mm;
  return moved;
}

double error_in(const std::vector<int>& vertices, const ControlPositions& positions) {
  double sum = 0;
  for (const int v : vertices) sum += (positions[v] - generic_head().positions[v]).norm();
  return sum / static_cast<double>(vertices.size());
}

TEST(FitLocal, MovesADisplacedFeatureBack) {
  const struct {
    const char* box;
    Eigen::Vector3d shift_mm;
  } cases[] = {{"ear_left", {0, 7, 4}}, {"ear_right", {1, -6, -5}}, {"nose", {0, 5, 2}}};
  for (const auto& c : cases) {
    const ControlPositions start = displace_feature(c.box, c.shift_mm);
    const LocalFitResult result = fit_local(generic_scan(), generic_head(), start);
    const auto vertices = vertices_in(c.box);
    EXPECT_LT(error_in(vertices, result.positions), 0.6 * error_in(vertices, start)) << c.box;
  }
}

TEST(FitLocal, LeavesAFittingHeadNearlyAlone) {
  const LocalFitResult result = fit_local(generic_scan(), generic_head(), generic_head().positions);
  EXPECT_LT(test::mean_distance(result.positions, generic_head().positions), 0.7);
  EXPECT_EQ(test::count_folds(result.positions, generic_head().positions), 0);
}

TEST(FitLocal, NeverRaisesTheEnergyOfABox) {
  const LocalFitResult result =
      fit_local(generic_scan(), generic_head(), displace_feature("nose", {2, 4, -3}));
  ASSERT_EQ(result.boxes.size(), generic_head().annotations.boxes.size());
  for (const LocalFitBox& box : result.boxes) {
    EXPECT_TRUE(generic_head().annotations.boxes.contains(box.name));
    if (box.applied) {
      EXPECT_LT(box.energy_after, box.energy_before) << box.name;
    }
  }
}

TEST(FitLocal, EffectFadesWithTheDistanceToTheFeatures) {
  const ControlPositions start = displace_feature("ear_left", {0, 7, 4});
  const LocalFitResult result = fit_local(generic_scan(), generic_head(), start);
  double near = 0, far = 0;
  for (std::size_t v = 0; v < start.size(); ++v) {
    double distance = 1e9;
    for (const auto& [name, box] : generic_head().annotations.boxes)
      distance = std::min(distance, box.exteriorDistance(generic_head().positions[v]));
    const double moved = (result.positions[v] - start[v]).norm();
    if (distance == 0) near = std::max(near, moved);
    if (distance > 60) far = std::max(far, moved);
  }
  EXPECT_GT(near, 2.0);
  EXPECT_LT(far, 0.15 * near);
}

TEST(FitLocal, WithoutAScanThereNothingMoves) {
  PointCloud cloud = test::sample_surface(generic_head().positions, 10'000);
  for (auto& p : cloud.positions) p.x() += 500;
  const LocalFitResult result = fit_local(ScanSurface(cloud), generic_head(), generic_head().positions);
  EXPECT_EQ(result.positions, generic_head().positions);
  for (const LocalFitBox& box : result.boxes) EXPECT_FALSE(box.applied) << box.name;
}

TEST(FitLocal, SameBitsAtAnyThreadCount) {
  const ControlPositions start = displace_feature("nose", {2, 4, -3});
  LocalFitResult one, two;
  with_threads(1, [&] { one = fit_local(generic_scan(), generic_head(), start); });
  with_threads(2, [&] { two = fit_local(generic_scan(), generic_head(), start); });
  EXPECT_EQ(one.positions, two.positions);
}

TEST(FitLocal, WantsOnePositionAVertex) {
  EXPECT_THROW(fit_local(generic_scan(), generic_head(), {}), ContractViolation);
}

}  // namespace
}  // namespace phiz
