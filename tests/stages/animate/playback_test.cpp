#include "stages/animate/playback.h"

#include <gtest/gtest.h>

#include "stages/animate/pose_solver.h"
#include "stages/geometry/error.h"
#include "tests/stages/animate/animate_samples.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

Motion make_motion(std::vector<std::string> names, std::vector<float> values, std::size_t frames) {
  Motion motion;
  motion.names = std::move(names);
  motion.values = std::move(values);
  for (std::size_t i = 0; i < frames; ++i) motion.times_s.push_back(static_cast<double>(i) / 60);
  return motion;
}

TEST(Playback, MusclesAndArkitNamesShareOneFile) {
  const auto layout = test::generic_layout();
  const ActivationTrack track = map_activations(
      *layout, make_motion({"MouthSmileLeft", "zygomaticMajorLeft", "HeadYaw"}, {0.5f, 0.25f, 1.0f}, 1));
  EXPECT_FLOAT_EQ(track.frames[0][layout->find_activation("zygomaticMajorLeft")], 0.75f)
      << "contributions add";
  EXPECT_EQ(track.unused, std::vector<std::string>{"HeadYaw"});
}

TEST(Playback, ActivationsSurviveTheMotionFile) {
  const auto layout = test::generic_layout();
  const Motion motion = make_motion({"jawOpen", "risoriusRight"}, {0.1f, 0.2f, 0.3f, 0.4f}, 2);
  const ActivationTrack track = map_activations(*layout, motion);
  const ActivationTrack again = map_activations(*layout, make_activation_motion(*layout, track));
  EXPECT_EQ(again.frames, track.frames);
  EXPECT_EQ(again.times_s, track.times_s);
}

TEST(Playback, UnknownNamesAreNamed) {
  const auto layout = test::generic_layout();
  EXPECT_THROW(map_activations(*layout, make_motion({"zygomaticMajor"}, {1.0f}, 1)), InvalidInput);
  EXPECT_THROW(map_activations(*layout, make_motion({"HeadYaw"}, {1.0f}, 1)), InvalidInput);
  const std::pair<std::string, double> unknown{"grin", 1.0};
  EXPECT_THROW(pose_activations(*layout, {&unknown, 1}), InvalidInput);
}

TEST(Playback, AllOfArkitsNamesAreKnown) {
  const auto layout = test::generic_layout();
  std::vector<std::string> names(arkit_names().begin(), arkit_names().end());
  const std::size_t count = names.size();
  const ActivationTrack track =
      map_activations(*layout, make_motion(names, std::vector<float>(count, 0.5f), 1));
  EXPECT_LE(track.unused.size(), 10u) << "the tongue and where the eyes look";
}

TEST(Playback, ClipIsTheSimulationWithinItsError) {
  const auto layout = test::generic_layout();
  const ControlMesh& head = test::generic_head();
  Skin skin(layout, head.positions);
  const std::pair<std::string, double> smile{"smile", 1.0};
  const ActivationTrack track = make_pose_track(pose_activations(*layout, {&smile, 1}), 0.5, 24, 0.1);
  const ControlFrames frames = play(skin, track);
  ASSERT_EQ(frames.size(), track.frames.size());
  const SubdivisionHierarchy hierarchy(head.triangles, static_cast<int>(head.positions.size()), 1);
  LivingSurface surface(std::make_shared<SurfacePlan>(hierarchy), {});
  ClipOptions options;
  options.level = 1;
  const Clip clip = make_clip(frames, track.times_s, surface, hierarchy, {}, options);
  EXPECT_LE(clip.error_mm, options.within_mm);
  EXPECT_EQ(clip.mesh.weights.size(), frames.size() * clip.mesh.targets.size());
  EXPECT_GT(clip.mesh.targets.size(), 0u);
  EXPECT_EQ(static_cast<int>(clip.mesh.mesh.vertex_count()), hierarchy.vertex_count(1));
}

/// Three inputs that bend a strip of points, a little nonlinear.
void bend(std::span<const float> inputs, std::vector<Eigen::Vector3f>& positions) {
  positions.clear();
  for (int i = 0; i < 30; ++i) {
    const float x = static_cast<float>(i) / 10;
    positions.emplace_back(x, inputs[0] * x * x + 0.1f * inputs[0] * inputs[1],
                           inputs[1] * std::sin(x) + inputs[2]);
  }
}

TEST(PoseSolver, FindsTheInputsOfAPose) {
  const std::vector<float> maxima = {1, 1, 1.5f};
  const PoseSolver solver(bend, maxima, std::vector<float>(30, 1.0f));
  for (const std::vector<float>& truth : {std::vector<float>{0.3f, 0.7f, 1.2f}, {0, 0, 0}, {1, 0.2f, 0}}) {
    std::vector<Eigen::Vector3f> posed;
    bend(truth, posed);
    for (std::size_t v = 0; v < posed.size(); ++v) posed[v] -= solver.rest()[v];
    const PoseSolver::Result result = solver.solve(posed, 8);
    for (std::size_t k = 0; k < truth.size(); ++k) EXPECT_NEAR(result.inputs[k], truth[k], 0.01) << k;
  }
}

TEST(PoseSolver, StaysWithinTheBounds) {
  const PoseSolver solver(bend, std::vector<float>{1, 1, 1}, std::vector<float>(30, 1.0f));
  const std::vector<Eigen::Vector3f> far(30, Eigen::Vector3f(0, -5, 9));
  for (const float input : solver.solve(far).inputs) EXPECT_TRUE(input >= 0 && input <= 1);
}

}  // namespace
}  // namespace phiz
