#include "stages/template/triangulate.h"

#include <gtest/gtest.h>

#include "stages/geometry/error.h"
#include "tests/stages/template/template_samples.h"

namespace phiz {
namespace {

using test::to_layout;

double doubled_area(const HalfMesh& mesh, const Eigen::Vector3i& t) {
  const Eigen::Vector2d a = mesh.vertices[t[1]].uv - mesh.vertices[t[0]].uv,
                        b = mesh.vertices[t[2]].uv - mesh.vertices[t[0]].uv;
  return a[0] * b[1] - a[1] * b[0];
}

bool has_edge(const HalfMesh& mesh, int a, int b) {
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      if (std::minmax(t[k], t[(k + 1) % 3]) == std::minmax(a, b)) return true;
    }
  }
  return false;
}

std::string refusal(const std::string& text) {
  try {
    triangulate_layout(to_layout(text));
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return {};
}

const std::string kCorners = "point c0 0.5 0\npoint c1 0.5 1\npoint c2 0 1\npoint c3 0 0\n";

TEST(Triangulate, CoversTheHalfSquareOnceWithEveryCurveAsEdges) {
  for (const std::string& text : {test::small_layout_text(), test::generic_layout_text()}) {
    const Layout layout = to_layout(text);
    const HalfMesh mesh = triangulate_layout(layout);
    double area = 0;
    for (const auto& t : mesh.triangles) {
      EXPECT_GT(doubled_area(mesh, t), 0);
      area += doubled_area(mesh, t) / 2;
    }
    EXPECT_NEAR(area, 0.5, 1e-9);
    for (const auto& curve : layout.curves) {
      for (std::size_t k = 0; k + 1 < curve.points.size(); ++k)
        EXPECT_TRUE(has_edge(mesh, curve.points[k], curve.points[k + 1])) << curve.name;
    }
    for (const auto& [a, b] : layout.edges) EXPECT_TRUE(has_edge(mesh, a, b));
  }
}

TEST(Triangulate, NamesCurvesThatCrossWithTheirLine) {
  const std::string points = "point a 0.1 0.1\npoint b 0.3 0.3\npoint c 0.1 0.3\npoint d 0.3 0.1\n";
  const std::string what = refusal(kCorners + points + "curve one a b\ncurve two c d\n");
  EXPECT_NE(what.find("curve 'two' (line 10) crosses"), std::string::npos) << what;
}

TEST(Triangulate, NamesACurveThatRunsThroughAPoint) {
  const std::string points = "point a 0.1 0.1\npoint b 0.3 0.1\npoint between 0.2 0.1\n";
  const std::string what = refusal(kCorners + points + "curve one a b\n");
  EXPECT_NE(what.find("curve 'one' (line 8) runs through another point"), std::string::npos) << what;
}

TEST(Triangulate, WantsTheCornersOfTheSquare) {
  EXPECT_NE(refusal("point a 0.5 0\npoint b 0 0\npoint c 0.3 0.5\n").find("no point at the corner"),
            std::string::npos);
}

}  // namespace
}  // namespace phiz
