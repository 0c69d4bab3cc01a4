#include "stages/adapt/compliance.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

std::vector<Eigen::Vector3d> positions_of(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3f& p : mesh.positions) positions.push_back(p.cast<double>());
  return positions;
}

/// A mesh with faces taken away, as long as it stays a manifold: many borders, odd counts, bridges.
TriangleMesh moth_eaten(TriangleMesh mesh, int holes) {
  for (int hole = 0; hole < holes; ++hole) {
    TriangleMesh smaller = mesh;
    smaller.triangles.erase(smaller.triangles.begin() +
                            static_cast<std::ptrdiff_t>(test::random().below(mesh.triangle_count())));
    try {
      is_compliant(smaller.triangles, static_cast<int>(mesh.vertex_count()));
      mesh = std::move(smaller);
    } catch (const std::exception&) {
    }
  }
  return mesh;
}

TEST(Compliance, MatchingNeedsNoVertexAndKeepsEveryTriangle) {
  std::vector<test::NamedMesh> meshes = test::mesh_zoo();
  for (int k = 0; k < 30; ++k) {
    meshes.push_back({"eaten sphere", moth_eaten(test::icosphere(2), 3 * k)});
    meshes.push_back({"eaten grid", moth_eaten(test::open_grid(9, 7), k)});
  }
  for (const auto& [name, mesh] : meshes) {
    const CompliantMesh made = make_compliant(mesh.triangles, positions_of(mesh));
    EXPECT_TRUE(is_compliant(made.triangles, made.vertex_count)) << name;
    EXPECT_EQ(made.vertex_count, static_cast<int>(mesh.vertex_count())) << name;
    EXPECT_EQ(made.inside_singles, 0) << name;
    EXPECT_EQ(2 * made.pairs + made.border_singles, static_cast<int>(mesh.triangle_count())) << name;
    ASSERT_EQ(made.triangles.size(), mesh.triangles.size());
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
      Eigen::Vector3i turned = made.triangles[f];
      for (int i = 0; i < 3 && turned != mesh.triangles[f]; ++i)
        turned = Eigen::Vector3i(turned[1], turned[2], turned[0]);
      EXPECT_EQ(turned, mesh.triangles[f]) << name;
    }
  }
}

TEST(Compliance, LongestFirstSplitsOnceAndSaysHowOften) {
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    const CompliantMesh made = make_compliant(mesh.triangles, positions_of(mesh), BlockOrder::kLongestFirst);
    EXPECT_TRUE(is_compliant(made.triangles, made.vertex_count)) << name;
    EXPECT_EQ(static_cast<int>(made.added.size()), made.pairs + made.border_singles + made.inside_singles);
    EXPECT_EQ(made.vertex_count, static_cast<int>(mesh.vertex_count() + made.added.size()));
    EXPECT_EQ(static_cast<int>(made.triangles.size()),
              4 * made.pairs + 2 * made.border_singles + 3 * made.inside_singles);
    for (const AddedVertex& added : made.added) {
      for (const int parent : added.parents) EXPECT_LT(parent, static_cast<int>(mesh.vertex_count()));
    }
  }
}

TEST(Compliance, PairsLongEdges) {
  // A grid of cells whose diagonals are the longest edges: they are the pairs.
  const TriangleMesh grid = test::open_grid(8, 8);
  const std::vector<Eigen::Vector3d> positions = positions_of(grid);
  for (const Eigen::Vector3i& t : make_compliant(grid.triangles, positions).triangles)
    EXPECT_NEAR((positions[t[1]] - positions[t[0]]).norm(), std::sqrt(2.0) / 8, 1e-6);
}

}  // namespace
}  // namespace phiz
