#include "stages/animate/skin.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "stages/geometry/error.h"
#include "tests/stages/animate/animate_samples.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using test::activate;

Skin make_skin(const SkinOptions& options = {}) {
  return Skin(test::generic_layout(), test::generic_head().positions, options);
}

Eigen::Vector3d landmark(const Skin& skin, const char* name) {
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3f& p : skin.positions()) positions.push_back(p.cast<double>());
  return skin.layout().place({{name, 1.0}}, false, positions);
}

/// The skin at rest under activations.
void pose(Skin& skin, const Activations& wanted) {
  skin.reset();
  skin.set_activations(activate(skin.layout(), wanted));
  skin.relax(120);
}

TEST(Skin, AtRestIsExactlyTheFittedHead) {
  Skin skin = make_skin();
  for (const double seconds : {1.0 / 24, 1.0 / 60, 1.0 / 1000}) skin.step(seconds);
  for (std::size_t v = 0; v < skin.positions().size(); ++v)
    ASSERT_EQ(skin.positions()[v], skin.rest_positions()[v]) << v;
}

TEST(Skin, ReturnsToRestWhenMusclesLetGo) {
  Skin skin = make_skin();
  skin.set_activations(activate(skin.layout(), *skin.layout().find_expression("laugh")));
  for (int i = 0; i < 20; ++i) skin.step(1.0 / 24);
  EXPECT_GT(skin.measure().farthest_mm, 5);
  skin.set_activations(activate(skin.layout(), {}));
  for (int i = 0; i < 160; ++i) skin.step(1.0 / 60);
  EXPECT_LT(skin.measure().farthest_mm, 0.01);
}

TEST(Skin, MusclesPullWhereAnatomySays) {
  Skin skin = make_skin();
  const Eigen::Vector3d corner = landmark(skin, "mouth_left_corner"), brow = landmark(skin, "brow_left_1");
  const Eigen::Vector3d chin = landmark(skin, "chin");
  pose(skin, {{"zygomaticMajorLeft", 1}});
  EXPECT_GT((landmark(skin, "mouth_left_corner") - corner).y(), 2) << "up";
  EXPECT_GT((landmark(skin, "mouth_left_corner") - corner).x(), 1) << "outwards";
  pose(skin, {{"depressorAnguliOrisLeft", 1}});
  EXPECT_LT((landmark(skin, "mouth_left_corner") - corner).y(), -2);
  pose(skin, {{"frontalisInnerLeft", 1}});
  EXPECT_GT((landmark(skin, "brow_left_1") - brow).y(), 2);
  pose(skin, {{"jawOpen", 1}});
  EXPECT_LT((landmark(skin, "chin") - chin).y(), -15);
  EXPECT_LT((landmark(skin, "brow_left_1") - brow).norm(), 0.2) << "the jaw does not move the brow";
}

TEST(Skin, SidesMirrorEachOther) {
  Skin skin = make_skin();
  pose(skin, {{"zygomaticMajorLeft", 0.8}, {"corrugatorLeft", 0.5}});
  const std::vector<Eigen::Vector3f> left(skin.positions().begin(), skin.positions().end());
  pose(skin, {{"zygomaticMajorRight", 0.8}, {"corrugatorRight", 0.5}});
  const std::vector<int>& mirror = test::generic_head().annotations.mirror;
  float worst = 0;
  for (std::size_t v = 0; v < left.size(); ++v) {
    const Eigen::Vector3f mirrored(-left[v].x(), left[v].y(), left[v].z());
    worst = std::max(worst, (skin.positions()[mirror[v]] - mirrored).norm());
  }
  EXPECT_LT(worst, 0.7);
}

TEST(Skin, LipsAndLidsDoNotPassThroughEachOther) {
  Skin skin = make_skin();
  const Activations squeeze = {{"orbicularisOculiLeft", 1},
                               {"orbicularisOculiRight", 1},
                               {"orbicularisOrisPress", 1},
                               {"mentalis", 1},
                               {"depressorAnguliOrisLeft", 1}};
  skin.set_activations(activate(skin.layout(), squeeze));
  for (int i = 0; i < 60; ++i) {
    skin.step(i % 2 == 0 ? 1.0 / 24 : 1.0 / 240);
    ASSERT_LT(skin.measure().crossing_mm, 0.2) << i;
  }
}

TEST(Skin, StaysStableAtAnyStepAndActivation) {
  Skin skin = make_skin();
  test::Random& random = test::random();
  for (int i = 0; i < 150; ++i) {
    std::vector<float> values;
    for (std::size_t a = 0; a < skin.layout().activations().size(); ++a)
      values.push_back(random.uniform() < 0.5 ? 0.0f : static_cast<float>(random.uniform()));
    skin.set_activations(values);
    skin.step(std::exp(random.uniform(std::log(1e-4), std::log(2.0))));
    const Skin::Figures figures = skin.measure();
    ASSERT_TRUE(std::isfinite(figures.kinetic + figures.elastic)) << i;
    ASSERT_LT(figures.farthest_mm, 80) << i;
  }
}

TEST(Skin, SameStepsSameBits) {
  Skin a = make_skin(), b = make_skin();
  for (Skin* skin : {&a, &b}) {
    if (skin == &b) {  // a used skin that was reset is a new one
      skin->set_activations(activate(skin->layout(), {{"jawOpen", 1}}));
      skin->step(0.1);
      skin->reset();
    }
    skin->set_activations(activate(skin->layout(), *skin->layout().find_expression("smile")));
    for (int i = 0; i < 10; ++i) skin->step(1.0 / 60);
  }
  EXPECT_EQ(std::memcmp(a.positions().data(), b.positions().data(), a.positions().size_bytes()), 0);
}

SkinOptions free_options() {
  SkinOptions options;
  options.is_tied = false;
  options.damping_s = 0;
  options.dissipation = 0;
  options.rounds = 40;
  return options;
}

TEST(Skin, FreeSkinKeepsMomentumAndEnergy) {
  Skin skin = make_skin(free_options());
  std::vector<Eigen::Vector3f> velocities;
  for (const Eigen::Vector3f& p : skin.rest_positions())
    velocities.emplace_back(20 + 0.5f * p.y(), -0.5f * p.x(), 10 * std::sin(0.05f * p.y()));
  skin.set_velocities(velocities);
  const Skin::Figures before = skin.measure();
  for (int i = 0; i < 20; ++i) skin.step(1.0 / 240);
  const Skin::Figures after = skin.measure();
  EXPECT_LT((after.momentum - before.momentum).norm(), 2e-3 * before.momentum.norm());
  const double energy = before.kinetic + before.elastic;
  EXPECT_NEAR(after.kinetic + after.elastic, energy, 0.02 * energy);
}

TEST(Skin, RefusesAnotherMesh) {
  const std::vector<Eigen::Vector3d> few(10, Eigen::Vector3d::Zero());
  EXPECT_THROW(Skin(test::generic_layout(), few), InvalidInput);
}

TEST(FaceLayout, NamesWhatTheHeadLacks) {
  ControlMesh head = test::generic_head();
  head.annotations.landmarks.erase("mouth_left_corner");
  try {
    FaceLayout layout(head, test::load_anatomy());
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("mouth_left_corner"), std::string::npos) << error.what();
  }
}

TEST(FaceLayout, UpperLipMusclesLeaveTheLowerLipAlone) {
  const auto layout = test::generic_layout();
  const auto& regions = test::generic_head().annotations.regions;
  for (const FaceLayout::Muscle& muscle : layout->muscles()) {
    if (muscle.shape.name != "levatorLabii") continue;
    double influence = 0;
    for (const auto& share : muscle.shares)
      if (test::generic_head().positions[share.vertex_idx].y() < -40) influence += share.influence;
    EXPECT_EQ(influence, 0);
  }
  EXPECT_TRUE(regions.contains("lips"));
}

}  // namespace
}  // namespace phiz
