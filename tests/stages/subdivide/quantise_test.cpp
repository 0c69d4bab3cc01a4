#include "stages/subdivide/quantise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

struct Sample {
  TriangleMesh disk = test::disk(8, 4);
  SubdivisionHierarchy hierarchy{disk.triangles, static_cast<int>(disk.vertex_count()), 3};
  std::vector<Eigen::Vector3d> control;
  std::vector<std::vector<float>> displacements;

  Sample() {
    for (const Eigen::Vector3f& p : disk.positions)
      control.push_back(60 * p.cast<double>() + Eigen::Vector3d(0, 0, 10 * (1 - p.squaredNorm())));
    for (int level = 0; level <= 3; ++level) {
      const int first = level == 0 ? 0 : hierarchy.vertex_count(level - 1);
      displacements.emplace_back(hierarchy.vertex_count(level), 0.0f);
      for (int v = first; v < hierarchy.vertex_count(level); ++v)
        displacements[level][v] = static_cast<float>(0.3 * test::random().normal() / (1 << level));
    }
  }
};

TEST(QuantiseSurface, StaysWithinTheToleranceAsMeasured) {
  const Sample sample;
  for (const double tolerance_mm : {0.01, 0.05, 0.2}) {
    const QuantisedSurface surface =
        quantise_surface(sample.hierarchy, sample.control, sample.displacements, {tolerance_mm, 0.01, 3});
    EXPECT_LE(surface.hausdorff_mm, tolerance_mm);
    const auto given = evaluate_surface(sample.hierarchy, sample.control, sample.displacements, 3);
    EXPECT_EQ(measure_hausdorff(given, surface.positions, sample.hierarchy.triangles(3)),
              surface.hausdorff_mm);
  }
}

TEST(QuantiseSurface, EveryNumberIsAWholeOfSteps) {
  const Sample sample;
  const QuantisedSurface surface =
      quantise_surface(sample.hierarchy, sample.control, sample.displacements, {0.05, 0.02, 3});
  for (const auto& level : surface.displacements_mm)
    for (const float d : level) EXPECT_NEAR(d / surface.step_mm, std::round(d / surface.step_mm), 1e-4);
  for (const Eigen::Vector3d& p : surface.control_positions)
    for (const double x : p)
      EXPECT_NEAR(x / surface.position_step_mm, std::round(x / surface.position_step_mm), 1e-3);
}

TEST(QuantiseSurface, EvaluationGivesItsPositions) {
  const Sample sample;
  const QuantisedSurface surface =
      quantise_surface(sample.hierarchy, sample.control, sample.displacements, {0.03, 0.01, 2});
  EXPECT_EQ(evaluate_surface(sample.hierarchy, surface.control_positions, surface.displacements_mm, 2),
            surface.positions);
}

}  // namespace
}  // namespace phiz
