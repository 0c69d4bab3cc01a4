#include "stages/deform/learn.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "stages/deform/deform.h"
#include "stages/deform/learn_pose.h"
#include "stages/geometry/error.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

ControlMesh load_head() {
  std::ifstream obj(PHIZ_SOURCE_FOLDER "/samples/generic_head/head.obj"),
      json(PHIZ_SOURCE_FOLDER "/samples/generic_head/head.json");
  return read_control_mesh(obj, json);
}

HeadAsset neutral_of(const ControlMesh& head) {
  HeadAsset asset;
  for (const Eigen::Vector3d& p : head.positions) asset.positions.push_back(p.cast<float>());
  asset.triangles = head.triangles;
  return asset;
}

/// A bump on the left cheek, exactly zero on the right half of the head.
std::vector<Eigen::Vector3d> left_bump(const ControlMesh& head) {
  std::vector<Eigen::Vector3d> vectors;
  const Eigen::Vector3d centre(45, 0, 70);
  for (const Eigen::Vector3d& p : head.positions) {
    const double size = p.x() > 10 ? 6 * std::exp(-(p - centre).squaredNorm() / 400) : 0;
    vectors.emplace_back(0.2 * size, size, -0.3 * size);
  }
  return vectors;
}

std::vector<Eigen::Vector3f> evaluate(const Deformation& rig, const NeutralSurface& neutral,
                                      const std::vector<float>& parameters) {
  const CompiledCascade cascade(rig, sample_fields(rig, neutral.uv), neutral);
  std::vector<Eigen::Vector3f> at(neutral.positions.size());
  cascade.evaluate(parameters, at);
  return at;
}

TEST(LearnedRig, GivesTheDisplacementsBackOnTheHeadTheyWereLearnedOn) {
  const ControlMesh head = load_head();
  const HeadAsset asset = neutral_of(head);
  const std::vector<Eigen::Vector3d> vectors = left_bump(head);
  for (const FieldAxes axes : {FieldAxes::kHead, FieldAxes::kLocal}) {
    FieldOptions options;
    options.axes = axes;
    const Deformation rig = make_learned_rig(head, asset, {{"bump", vectors}}, "test", options);
    const NeutralSurface neutral = NeutralMaker(head, 0).make(head.positions, {});
    const auto at = evaluate(rig, neutral, {1});
    for (std::size_t v = 0; v < vectors.size(); ++v)
      EXPECT_LT(((at[v] - neutral.positions[v]).cast<double>() - vectors[v]).norm(), 0.35);
    EXPECT_EQ(evaluate(rig, neutral, {0}), neutral.positions);  // bit for bit
  }
}

TEST(LearnedRig, SplitHalvesAddUpToTheWholeAndStayOnTheirSides) {
  const ControlMesh head = load_head();
  const HeadAsset asset = neutral_of(head);
  const std::vector<Eigen::Vector3d> vectors(head.positions.size(), Eigen::Vector3d(1, 2, 3));
  FieldOptions options;
  options.is_split = true;
  const Deformation rig = make_learned_rig(head, asset, {{"lift", vectors}}, "test", options);
  ASSERT_EQ(rig.parameters.size(), 2u);
  EXPECT_EQ(rig.parameters[0].name, "liftLeft");
  const NeutralSurface neutral = NeutralMaker(head, 0).make(head.positions, {});
  const auto both = evaluate(rig, neutral, {1, 1}), left = evaluate(rig, neutral, {1, 0});
  for (std::size_t v = 0; v < both.size(); ++v) {
    EXPECT_LT((both[v] - neutral.positions[v] - Eigen::Vector3f(1, 2, 3)).norm(), 0.01f);
    if (head.positions[v].x() < -25) {
      EXPECT_LT((left[v] - neutral.positions[v]).norm(), 0.05f);
    }
  }
}

TEST(LearnedRig, SymmetricFieldsAreTheirOwnMirrorImage) {
  const ControlMesh head = load_head();
  FieldOptions options;
  options.is_symmetric = true;
  const Deformation rig =
      make_learned_rig(head, neutral_of(head), {{"bump", left_bump(head)}}, "test", options);
  const NeutralSurface neutral = NeutralMaker(head, 0).make(head.positions, {});
  const auto at = evaluate(rig, neutral, {1});
  for (std::size_t v = 0; v < at.size(); ++v) {
    const Eigen::Vector3f here = at[v] - neutral.positions[v];
    const std::size_t other = head.annotations.mirror[v];
    const Eigen::Vector3f there = at[other] - neutral.positions[other];
    EXPECT_LT((here - Eigen::Vector3f(-there.x(), there.y(), there.z())).norm(), 0.3f);
  }
}

TEST(LearnPose, ACommonMotionIsFoundExactlyWhateverElseMoves) {
  std::vector<Eigen::Vector3d> from, to;
  Eigen::Isometry3d motion(Eigen::AngleAxisd(0.02, Eigen::Vector3d(1, -1, 0.5).normalized()));
  motion.translation() = Eigen::Vector3d(1, -2, 0.5);
  for (int i = 0; i < 400; ++i) {
    from.emplace_back(test::random().normal() * 60, test::random().normal() * 80,
                      test::random().normal() * 60);
    to.push_back(motion * from.back());
  }
  const std::vector<double> weights(from.size(), 1.0);
  EXPECT_LT((find_common_motion(from, to, weights).matrix() - motion.matrix()).norm(), 1e-11);
  for (int i = 0; i < 100; ++i) to[i] += Eigen::Vector3d(0, 8, 3);
  const Eigen::Isometry3d found = find_common_motion(from, to, weights);
  for (int i = 100; i < 400; ++i) EXPECT_LT((found * from[i] - to[i]).norm(), 0.02);
}

TEST(LearnExpression, RefusesAHeadOfAnotherConnectivity) {
  const ControlMesh head = load_head();
  HeadAsset asset = neutral_of(head);
  asset.positions.pop_back();
  EXPECT_THROW(ExpressionLearner(head, asset, nullptr), InvalidInput);
}

}  // namespace
}  // namespace phiz
