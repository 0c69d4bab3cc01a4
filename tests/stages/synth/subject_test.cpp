#include <gtest/gtest.h>

#include <cmath>

#include "stages/geometry/error.h"
#include "stages/geometry/normals.h"
#include "stages/geometry/parallel.h"
#include "tests/stages/synth/synth_samples.h"

namespace phiz::test {
namespace {

using Eigen::Vector3d;

double largest_move(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b) {
  double largest = 0;
  for (std::size_t v = 0; v < a.size(); ++v) largest = std::max(largest, (a[v] - b[v]).norm());
  return largest;
}

SubjectRecipe slider(const std::string& name, double value) {
  SubjectRecipe recipe;
  recipe.sliders[name] = value;
  return recipe;
}

SubjectRecipe expression(const std::string& name, double value) {
  SubjectRecipe recipe;
  recipe.expressions[name] = value;
  return recipe;
}

std::vector<SubjectRecipe> all_at(double slider_value, double expression_value) {
  std::vector<SubjectRecipe> recipes;
  for (const Variation& each : list_sliders()) recipes.push_back(slider(each.name, slider_value));
  for (const Variation& each : list_expressions()) {
    recipes.push_back(expression(each.name, expression_value));
  }
  return recipes;
}

TEST(Subject, SlidersAtZeroGiveTheGenericHeadBitForBit) {
  const SubjectBase& base = generic_base(2);
  EXPECT_EQ(make_subject(base, {}), base.positions);
  SubjectRecipe zeros;
  for (const Variation& each : list_sliders()) zeros.sliders[each.name] = 0;
  for (const Variation& each : list_expressions()) zeros.expressions[each.name] = 0;
  EXPECT_EQ(make_subject(base, zeros), base.positions);
}

TEST(Subject, LevelZeroIsTheControlMesh) {
  EXPECT_EQ(generic_base(0).positions, read_generic_head().positions);
}

TEST(Subject, EverySliderAndExpressionIsMirrorSymmetric) {
  const ControlMesh head = read_generic_head();
  const SubjectBase& base = generic_base(0);
  ASSERT_EQ(head.annotations.mirror.size(), base.positions.size());
  for (const SubjectRecipe& recipe : all_at(2, 1)) {
    const std::vector<Vector3d> positions = make_subject(base, recipe);
    for (std::size_t v = 0; v < positions.size(); ++v) {
      const Vector3d image = positions[head.annotations.mirror[v]].cwiseProduct(Vector3d(-1, 1, 1));
      ASSERT_LT((image - positions[v]).norm(), 1e-9) << v;
    }
  }
}

TEST(Subject, AmplitudesAreWhatMovesMostAtOne) {
  const SubjectBase& base = generic_base(1);
  for (const Variation& each : list_sliders()) {
    const double moved = largest_move(make_subject(base, slider(each.name, 1)), base.positions);
    EXPECT_GT(moved, 0.4 * each.amplitude_mm) << each.name;
    EXPECT_LT(moved, 2.0 * each.amplitude_mm) << each.name;
  }
  for (const Variation& each : list_expressions()) {
    const double moved = largest_move(make_subject(base, expression(each.name, 1)), base.positions);
    EXPECT_GT(moved, 0.4 * each.amplitude_mm) << each.name;
    EXPECT_LT(moved, 1.5 * each.amplitude_mm) << each.name;
  }
}

TEST(Subject, DisplacementsAddUp) {
  const SubjectBase& base = generic_base(0);
  SubjectRecipe both = slider("nose_length", 1.5);
  both.sliders["jaw_width"] = -1;
  const auto sum = make_subject(base, both), nose = make_subject(base, slider("nose_length", 1.5)),
             jaw = make_subject(base, slider("jaw_width", -1));
  for (std::size_t v = 0; v < sum.size(); ++v) {
    EXPECT_LT((sum[v] - nose[v] - jaw[v] + base.positions[v]).norm(), 1e-9);
  }
}

/// Share of the area whose triangles turn by more than 90 degrees.
double folded_share(const SubjectBase& base, const std::vector<Vector3d>& positions) {
  double folded = 0, all = 0;
  for (const Eigen::Vector3i& t : base.triangles) {
    const auto area = [&](const std::vector<Vector3d>& p) -> Vector3d {
      return (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]);
    };
    const Vector3d before = area(base.positions), after = area(positions);
    all += before.norm();
    if (before.dot(after) < 0) folded += before.norm();
  }
  return folded / all;
}

TEST(Subject, ExtremeSlidersFoldNothing) {
  const SubjectBase& base = generic_base(2);
  for (const double value : {-2.5, 2.5}) {
    for (const Variation& each : list_sliders()) {
      EXPECT_LT(folded_share(base, make_subject(base, slider(each.name, value))), 2e-4) << each.name << value;
    }
  }
}

TEST(Subject, DrawnSubjectsDifferAndDoNotFold) {
  const SubjectBase& base = generic_base(2);
  std::vector<std::vector<Vector3d>> subjects;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    subjects.push_back(make_subject(base, draw_recipe(seed)));
    EXPECT_LT(folded_share(base, subjects.back()), 1e-3) << seed;
  }
  for (int i = 1; i < 4; ++i) EXPECT_GT(largest_move(subjects[0], subjects[i]), 3.0);
  EXPECT_EQ(make_subject(base, draw_recipe(3)), subjects[2]);
}

TEST(Subject, IsTheSameAtAnyThreadCount) {
  const SubjectBase& base = generic_base(2);
  std::vector<Vector3d> one, two;
  with_threads(1, [&] { one = make_subject(base, draw_recipe(9)); });
  with_threads(2, [&] { two = make_subject(base, draw_recipe(9)); });
  EXPECT_EQ(one, two);
}

TEST(Subject, JawOpenMovesTheChinAndLeavesTheSkull) {
  const SubjectBase& base = generic_base(1);
  const auto open = make_subject(base, expression("jawOpen", 1));
  const auto moved = [&](const std::string& landmark) {
    const SurfacePoint& point = base.landmarks.at(landmark);
    return (position_at(point, base.triangles, open) - position_at(point, base.triangles, base.positions))
        .eval();
  };
  EXPECT_LT(moved("chin").y(), -10);
  EXPECT_LT(moved("mouth_outer_09").y(), -8);
  EXPECT_LT(moved("mouth_outer_03").norm(), 0.5);
  EXPECT_LT(moved("nose_tip").norm(), 1e-9);
  EXPECT_LT(moved("ear_top_left").norm(), 1e-9);
}

TEST(Subject, UnknownNamesAndNoNumbersAreRefused) {
  const SubjectBase& base = generic_base(0);
  EXPECT_THROW(make_subject(base, slider("nose", 1)), InvalidInput);
  EXPECT_THROW(make_subject(base, expression("jawopen", 1)), InvalidInput);
  EXPECT_THROW(make_subject(base, slider("nose_length", std::nan(""))), InvalidInput);
}

TEST(Subject, HeadWithoutAnnotationsIsRefused) {
  ControlMesh head = read_generic_head();
  head.annotations.landmarks.erase("chin");
  EXPECT_THROW(make_subject_base(head, 0), InvalidInput);
  head = read_generic_head();
  head.annotations.regions.erase("ears");
  EXPECT_THROW(make_subject_base(head, 0), InvalidInput);
}

TEST(RefineSurfacePoint, KeepsThePlaceInTheControlTriangle) {
  const ControlMesh head = read_generic_head();
  const SubdivisionHierarchy hierarchy(head.triangles, static_cast<int>(head.positions.size()), 3);
  const std::vector<Eigen::Vector2d> uv = evaluate_uv(hierarchy, head.uv, 3);
  for (const auto& [name, point] : head.annotations.landmarks) {
    const SurfacePoint fine = refine_surface_point(hierarchy, 3, point);
    Eigen::Vector2d before = Eigen::Vector2d::Zero(), after = before;
    for (int i = 0; i < 3; ++i) {
      before += point.weights[i] * head.uv[head.triangles[point.triangle_idx][i]];
      after += fine.weights[i] * uv[hierarchy.triangles(3)[fine.triangle_idx][i]];
    }
    EXPECT_LT((before - after).norm(), 1e-7) << name;
  }
}

}  // namespace
}  // namespace phiz::test
