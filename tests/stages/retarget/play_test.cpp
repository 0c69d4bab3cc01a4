#include <gtest/gtest.h>

#include "stages/retarget/retarget.h"
#include "tests/stages/deform/deform_samples.h"

namespace phiz {
namespace {

struct Fixture {
  Deformation rig = test::make_sample_deformation();
  NeutralSurface neutral = test::make_sample_surface(500);
  CompiledCascade cascade{rig, sample_fields(rig, neutral.uv), neutral};
  std::vector<Eigen::Vector3i> triangles = {{0, 1, 2}, {3, 4, 5}};

  ParameterTrack track(const std::vector<std::vector<float>>& frames) const {
    ParameterTrack made;
    made.parameter_count = 5;
    for (const std::vector<float>& frame : frames) {
      made.times_s.push_back(static_cast<double>(made.times_s.size()) / 30);
      made.values.insert(made.values.end(), frame.begin(), frame.end());
    }
    return made;
  }
};

TEST(Play, NothingMovesInANeutralMotion) {
  const Fixture f;
  const MotionFigures figures =
      measure_motion(f.cascade, f.neutral, f.track({{0, 0, 0, 0, 0}, {0, 0, 0, 0, 0}}));
  EXPECT_EQ(figures.largest_mm, 0);
  EXPECT_EQ(figures.mean_mm, 0);
}

TEST(Play, MorphTargetsAreExactWhereTheCascadeAdds) {
  const Fixture f;
  const ParameterTrack track = f.track({{0, 0, 0, 0, 0}, {1, 0.5f, 0, 0, 0}, {0.3f, -0.4f, 0, 0, 0}});
  const AnimatedMesh mesh = make_animated_mesh(f.cascade, f.neutral, f.rig, track, f.triangles);
  ASSERT_EQ(mesh.targets.size(), 2u);  // what no frame uses is left out
  EXPECT_EQ(mesh.targets[0].name, "smile");
  EXPECT_LT(measure_morph_error(f.cascade, mesh, track), 1e-3);
  EXPECT_EQ(mesh.mesh.positions, f.neutral.positions);
}

TEST(Play, MorphTargetsAreExactAtOneAlsoWhereItTurns) {
  const Fixture f;
  const ParameterTrack full = f.track({{0, 0, 1, 0, 0}}),
                       half = f.track({{0, 0, 0.5f, 0, 0}, {0, 0, 1, 0, 0}});
  EXPECT_LT(measure_morph_error(f.cascade, make_animated_mesh(f.cascade, f.neutral, f.rig, full, f.triangles),
                                full),
            1e-4);
  EXPECT_GT(measure_morph_error(f.cascade, make_animated_mesh(f.cascade, f.neutral, f.rig, half, f.triangles),
                                half),
            0.01);
}

}  // namespace
}  // namespace phiz
