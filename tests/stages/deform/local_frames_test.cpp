#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "stages/deform/deform.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

const ControlMesh& generic_head() {
  static const ControlMesh head = [] {
    const std::string folder = PHIZ_SOURCE_FOLDER "/samples/generic_head/";
    std::ifstream mesh(folder + "head.obj"), annotations(folder + "head.json");
    return read_control_mesh(mesh, annotations);
  }();
  return head;
}

TEST(LocalFrames, AreTheIdentityOnTheGenericHead) {
  const ControlMesh& head = generic_head();
  for (const Eigen::Quaterniond& frame : LocalFrames(head).compute(head.positions))
    EXPECT_LT(frame.angularDistance(Eigen::Quaterniond::Identity()), 1e-6);
}

TEST(LocalFrames, TurnWithTheHead) {
  const ControlMesh& head = generic_head();
  const Eigen::AngleAxisd turn(0.4, Eigen::Vector3d(1, 2, -1).normalized());
  std::vector<Eigen::Vector3d> turned;
  for (const Eigen::Vector3d& p : head.positions)
    turned.push_back(1.1 * (turn * p) + Eigen::Vector3d(5, -3, 8));
  for (const Eigen::Quaterniond& frame : LocalFrames(head).compute(turned))
    EXPECT_LT(frame.angularDistance(Eigen::Quaterniond(turn)), 0.01);
}

TEST(NeutralMaker, CoarseVerticesAreTheSameAtEveryLevel) {
  const ControlMesh& head = generic_head();
  std::vector<Eigen::Vector3d> subject;
  for (const Eigen::Vector3d& p : head.positions)
    subject.push_back({1.05 * p.x(), p.y() + 0.02 * p.z(), p.z() + 3 * std::sin(0.05 * p.y())});
  const NeutralSurface coarse = NeutralMaker(head, 1).make(subject, {}),
                       fine = NeutralMaker(head, 2).make(subject, {});
  ASSERT_LT(coarse.positions.size(), fine.positions.size());
  for (std::size_t i = 0; i < coarse.positions.size(); ++i) {
    EXPECT_EQ(coarse.positions[i], fine.positions[i]);
    EXPECT_EQ(coarse.uv[i], fine.uv[i]);
    EXPECT_EQ(coarse.frames[i], fine.frames[i]);
  }
  EXPECT_TRUE(fine.landmarks.contains("nose_tip"));
}

}  // namespace
}  // namespace phiz
