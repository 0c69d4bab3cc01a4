#include "stages/template/average.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "stages/geometry/error.h"
#include "stages/template/check.h"
#include "tests/stages/template/template_samples.h"

namespace phiz {
namespace {

using test::generic_head;
using Positions = std::vector<Eigen::Vector3d>;

Positions turned(Positions positions, double angle, const Eigen::Vector3d& step) {
  const Eigen::AngleAxisd turn(angle, Eigen::Vector3d(1, 2, -1).normalized());
  for (auto& p : positions) p = turn * p + step;
  return positions;
}

TEST(AverageHeads, OfTheHeadItselfInAnyPoseIsTheHead) {
  const ControlMesh& head = generic_head();
  const ControlMesh mean =
      average_heads(head, std::vector<Positions>{turned(head.positions, 0.3, {5, -80, 12}),
                                                 turned(head.positions, -1, {0, 3, 0})});
  for (std::size_t v = 0; v < head.positions.size(); ++v)
    EXPECT_LT((mean.positions[v] - head.positions[v]).norm(), 0.02);
  EXPECT_EQ(mean.triangles, head.triangles);
  EXPECT_EQ(mean.uv, head.uv);
}

TEST(AverageHeads, OfALargeAndASmallHeadIsBetweenThemAndSymmetric) {
  const ControlMesh& head = generic_head();
  Positions large = head.positions, lopsided = head.positions;
  for (auto& p : large) p *= 1.1;
  for (auto& p : lopsided) p[1] += 0.05 * p[0];
  const ControlMesh mean = average_heads(head, std::vector<Positions>{large, lopsided});
  const auto height = [](const ControlMesh& mesh) {
    double top = -1e9;
    for (const auto& p : mesh.positions) top = std::max(top, p[1]);
    return top + 83;
  };
  EXPECT_GT(height(mean), height(head));
  const auto checks = check_generic_head(mean);
  for (const char* what : {"mirror symmetry of positions", "landmarks without mirror image"})
    EXPECT_EQ(test::find_value(checks, what).substr(0, 1), "0") << what;
  EXPECT_EQ(test::find_value(checks, "crossing triangles at level 4"), "0");
  const auto& box = mean.annotations.boxes.at("nose");
  EXPECT_GT(box.sizes().norm(), head.annotations.boxes.at("nose").sizes().norm());
}

TEST(AverageHeads, RefusesWhatIsNoFitOfTheHead) {
  const ControlMesh& head = generic_head();
  EXPECT_THROW(average_heads(head, {}), InvalidInput);
  EXPECT_THROW(average_heads(head, std::vector<Positions>{Positions(7)}), InvalidInput);
  ControlMesh unmirrored = head;
  unmirrored.annotations.mirror.clear();
  EXPECT_THROW(average_heads(unmirrored, std::vector<Positions>{head.positions}), InvalidInput);
}

}  // namespace
}  // namespace phiz
