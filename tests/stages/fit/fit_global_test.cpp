#include <gtest/gtest.h>

#include <cmath>

#include "stages/geometry/error.h"
#include "stages/geometry/half_edge.h"
#include "stages/geometry/parallel.h"
#include "tests/stages/fit/fit_samples.h"

namespace phiz {
namespace {

using test::generic_head;
using test::generic_hierarchy;

/// Another head on the generic head's control vertices.
ControlPositions make_other_head(const SubjectRecipe& recipe) {
  return make_subject(test::generic_base(0), recipe);
}

SubjectRecipe plain_recipe() {
  SubjectRecipe recipe;
  recipe.sliders = {{"head_width", 1.0}, {"nose_length", 1.0}};
  return recipe;
}

const ScanSurface& other_scan() {
  static const ScanSurface scan(test::sample_surface(make_other_head(plain_recipe()), 40'000));
  return scan;
}

GlobalFitOptions short_fit() {
  GlobalFitOptions options;
  options.rounds = 3;
  options.soft_rounds = 1;
  options.iterations_per_round = 2;
  return options;
}

GlobalFitResult fit(const GlobalFitOptions& options, const GlobalFitState* resume = nullptr,
                    const GlobalFitProgress& progress = {}) {
  return fit_global(other_scan(), generic_head(), generic_hierarchy(), generic_head().positions, options,
                    resume, progress);
}

void expect_same_bits(const GlobalFitResult& a, const GlobalFitResult& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.energies, b.energies);
  EXPECT_EQ(a.mean_distance_mm, b.mean_distance_mm);
  EXPECT_EQ(a.matched_share, b.matched_share);
}

TEST(FitGlobal, StaysAtTheTruthOfANoiselessScan) {
  const ControlPositions& truth = generic_head().positions;
  const ScanSurface scan(test::sample_surface(truth, 60'000));
  const GlobalFitResult result = fit_global(scan, generic_head(), generic_hierarchy(), truth);
  EXPECT_LT(test::mean_surface_error(result.positions, truth),
            0.16);  // with the unmeasured inside of the mouth
  EXPECT_LT(test::mean_distance(result.positions, truth),
            0.6);  // along the surface: surfels are 2.5 mm apart
  EXPECT_LT(result.mean_distance_mm, 0.1);
  EXPECT_GT(result.matched_share, 0.95);
  EXPECT_EQ(test::count_folds(result.positions, truth), 0);
}

TEST(FitGlobal, FindsAnotherHead) {
  const ControlPositions truth = make_other_head(plain_recipe());
  const double before = test::mean_distance(generic_head().positions, truth);
  const GlobalFitResult result = fit({});
  EXPECT_LT(test::mean_surface_error(result.positions, truth), 0.2);
  EXPECT_LT(test::mean_distance(result.positions, truth), 0.6 * before);
  EXPECT_EQ(test::count_folds(result.positions, generic_head().positions), 0);
}

TEST(FitGlobal, GoesOnFromEveryStateToTheSameBits) {
  const GlobalFitResult whole = fit(short_fit());
  std::vector<GlobalFitState> states;
  expect_same_bits(whole, fit(short_fit(), nullptr, [&](const GlobalFitState& state) {
                     states.push_back(state);
                     return true;
                   }));
  ASSERT_EQ(states.size(), whole.energies.size());
  for (std::size_t k = 0; k < states.size(); k += k + 3 < states.size() ? 3 : 1) {
    SCOPED_TRACE("state " + std::to_string(k));
    expect_same_bits(whole, fit(short_fit(), &states[k]));
  }
}

TEST(FitGlobal, StopsWhenToldAndTheStateToldLeadsToTheSameBits) {
  const GlobalFitResult whole = fit(short_fit());
  GlobalFitState stopped;
  const GlobalFitResult part = fit(short_fit(), nullptr, [&](const GlobalFitState& state) {
    stopped = state;
    return state.energies.size() < 3;
  });
  EXPECT_EQ(part.energies.size(), 3u);
  EXPECT_EQ(part.positions, stopped.positions);
  expect_same_bits(whole, fit(short_fit(), &stopped));
}

TEST(FitGlobal, SameBitsAtAnyThreadCount) {
  GlobalFitResult one, two;
  with_threads(1, [&] { one = fit(short_fit()); });
  with_threads(2, [&] { two = fit(short_fit()); });
  expect_same_bits(one, two);
}

TEST(FitGlobal, NeckLoopEndsOnTheNeckPlane) {
  GlobalFitOptions options;
  options.neck = generic_head().annotations.clipping_planes.at("neck");
  options.neck->offset_mm += 6;
  PointCloud cloud = test::sample_surface(make_other_head(plain_recipe()), 40'000), cut;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (options.neck->normal.dot(cloud.positions[i].cast<double>()) < options.neck->offset_mm) continue;
    cut.positions.push_back(cloud.positions[i]);
    cut.normals.push_back(cloud.normals[i]);
    cut.confidences.push_back(1);
  }
  const GlobalFitResult result =
      fit_global(ScanSurface(cut), generic_head(), generic_hierarchy(), generic_head().positions, options);
  const HalfEdgeMesh mesh(generic_head().triangles, static_cast<int>(result.positions.size()));
  for (const auto& loop : mesh.border_loops())
    for (const int v : loop)
      EXPECT_NEAR(options.neck->normal.dot(result.positions[v]), options.neck->offset_mm, 1.0);
  EXPECT_EQ(test::count_folds(result.positions, generic_head().positions), 0);
}

TEST(FitGlobal, GrossOutliersDoNotPull) {
  PointCloud cloud = test::sample_surface(generic_head().positions, 40'000);
  for (std::size_t i = 0; i < cloud.size(); i += 50) cloud.positions[i] += 6 * cloud.normals[i];
  const GlobalFitResult result =
      fit_global(ScanSurface(cloud), generic_head(), generic_hierarchy(), generic_head().positions);
  EXPECT_LT(test::mean_surface_error(result.positions, generic_head().positions), 0.15);
}

TEST(FitGlobal, RejectsAScanThatIsElsewhere) {
  PointCloud cloud = test::sample_surface(generic_head().positions, 10'000);
  for (auto& p : cloud.positions) p.x() += 500;
  const ScanSurface scan(cloud);
  EXPECT_THROW(fit_global(scan, generic_head(), generic_hierarchy(), generic_head().positions, short_fit()),
               FitRejected);
}

TEST(FitGlobal, RejectsASurfaceTurnedInsideOut) {
  PointCloud cloud = test::sample_surface(generic_head().positions, 10'000);
  for (auto& n : cloud.normals) n = -n;
  const ScanSurface scan(cloud);
  EXPECT_THROW(fit_global(scan, generic_head(), generic_hierarchy(), generic_head().positions, short_fit()),
               FitRejected);
}

TEST(FitGlobal, WantsOnePositionAVertex) {
  ControlPositions start = generic_head().positions;
  start.pop_back();
  EXPECT_THROW(fit_global(other_scan(), generic_head(), generic_hierarchy(), start), ContractViolation);
}

}  // namespace
}  // namespace phiz
