#include <gtest/gtest.h>

#include <sstream>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "stages/template/check.h"
#include "stages/template/template.h"
#include "tests/stages/template/template_samples.h"

namespace phiz {
namespace {

using test::generic_head;
using test::list_short;
using test::to_layout;

std::string to_text(const ControlMesh& head) {
  std::ostringstream mesh, annotations;
  write_control_mesh(head, mesh, annotations);
  return mesh.str() + annotations.str();
}

/// Little relaxation: no good head, but all steps are taken.
TemplateOptions make_quick_options() {
  TemplateOptions options;
  options.coarse_rounds = 2;
  options.relax_sweeps = 40;
  options.limit.rounds = 1;
  options.settle_rounds = 0;
  options.domain.rounds = 1;
  return options;
}

TEST(BuildGenericHead, RebuildsOurHeadFromItsLayoutWithEveryPromiseKept) {
  const Layout layout = to_layout(test::generic_layout_text());
  const ControlMesh head = build_generic_head(layout, map_head(generic_head()));
  const auto bad = list_short(check_generic_head(head));
  EXPECT_TRUE(bad.empty()) << bad.front();
  EXPECT_EQ(head.positions.size(), generic_head().positions.size());
  for (const auto& [name, point] : generic_head().annotations.landmarks) {
    ASSERT_TRUE(head.annotations.landmarks.contains(name)) << name;
    const Eigen::Vector3d place =
        position_at(head.annotations.landmarks.at(name), head.triangles, head.positions);
    EXPECT_LT((place - position_at(point, generic_head().triangles, generic_head().positions)).norm(), 1.5)
        << name;
  }
  for (const auto& [name, vertices] : generic_head().annotations.regions)
    EXPECT_TRUE(head.annotations.regions.contains(name)) << name;
}

TEST(BuildGenericHead, GivesTheSameBytesAtAnyNumberOfThreads) {
  const Layout layout = to_layout(test::generic_layout_text());
  const MappedSurface surface = map_head(generic_head());
  std::string one, two;
  with_threads(1, [&] { one = to_text(build_generic_head(layout, surface, make_quick_options())); });
  with_threads(2, [&] { two = to_text(build_generic_head(layout, surface, make_quick_options())); });
  EXPECT_EQ(one, two);
}

TEST(BuildGenericHead, IsMirrorSymmetricToTheLastBit) {
  const Layout layout = to_layout(test::generic_layout_text());
  const ControlMesh head = build_generic_head(layout, map_head(generic_head()), make_quick_options());
  const auto& mirror = head.annotations.mirror;
  for (std::size_t v = 0; v < mirror.size(); ++v) {
    const auto &p = head.positions[v], &q = head.positions[mirror[v]];
    EXPECT_EQ(p, Eigen::Vector3d(-q[0], q[1], q[2]));
  }
  for (const auto& [name, region] : head.annotations.regions) EXPECT_FALSE(region.empty()) << name;
}

TEST(BuildGenericHead, RefusesARegionThatLeaks) {
  std::string text = test::generic_layout_text();
  const std::string walls = "within ear_base";
  text.erase(text.find(walls), walls.size());
  try {
    build_generic_head(to_layout(text), map_head(generic_head()), make_quick_options());
    ADD_FAILURE() << "taken";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("region 'ear_right' (line "), std::string::npos) << error.what();
  }
}

TEST(MapHead, LiesOnTheHeadAndRefusesAFoldedSquare) {
  const MappedSurface surface = map_head(generic_head());
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    EXPECT_LE(surface.uv[v][0], 0.5);
    if (surface.uv[v][0] == 0.5) {
      EXPECT_EQ(surface.positions[v][0], 0);
    }
  }
  ControlMesh folded = generic_head();
  for (auto& uv : folded.uv) {
    if (uv[0] > 0.2 && uv[0] < 0.3) uv[0] = 0.4;
  }
  EXPECT_THROW(map_head(folded), InvalidInput);
}

}  // namespace
}  // namespace phiz
