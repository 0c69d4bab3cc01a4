#include "stages/adapt/stellar_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "stages/geometry/error.h"
#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

StellarMesh mesh_of(const TriangleMesh& mesh) {
  return StellarMesh(mesh.triangles, static_cast<int>(mesh.vertex_count()));
}

/// Faces by slot, each turned so that its smallest corner comes first; free slots are (-1, -1, -1).
std::vector<std::array<int, 3>> canonical(const StellarMesh& mesh) {
  std::vector<std::array<int, 3>> faces;
  for (int f = 0; f < mesh.face_slots(); ++f) {
    if (!mesh.is_face(f)) {
      faces.push_back({-1, -1, -1});
      continue;
    }
    std::array<int, 3> corners = mesh.corners(f);
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    faces.push_back(corners);
  }
  while (!faces.empty() && faces.back()[0] < 0) faces.pop_back();
  return faces;
}

int euler(const StellarMesh& mesh) {
  int sides = 0, borders = 0;
  for (int f = 0; f < mesh.face_slots(); ++f) {
    for (int i = 0; mesh.is_face(f) && i < 3; ++i, ++sides)
      borders += mesh.twin(StellarMesh::half_edge(f, i)) < 0;
  }
  return mesh.vertex_count() - (sides + borders) / 2 + mesh.face_count();
}

std::string first_broken(const StellarMesh& mesh) {
  const std::vector<std::string> broken = mesh.validate();
  return broken.empty() ? "" : broken.front();
}

TEST(StellarMesh, EdgeSplitAndWeldAreInverseOnEveryEdgeOfTheZoo) {
  for (const auto& [name, zoo] : test::mesh_zoo()) {
    StellarMesh mesh = mesh_of(zoo);
    const auto before = canonical(mesh);
    const int characteristic = euler(mesh);
    for (int f = 0; f < static_cast<int>(zoo.triangle_count()); ++f) {
      for (int i = 0; i < 3; ++i) {
        const int h = StellarMesh::half_edge(f, i), a = mesh.from(h);
        const bool is_border = mesh.twin(h) < 0;
        const int v = mesh.split_edge(h);
        ASSERT_EQ(first_broken(mesh), "") << name;
        ASSERT_EQ(euler(mesh), characteristic);
        EXPECT_EQ(mesh.valence(v), is_border ? 3 : 4);
        EXPECT_EQ(mesh.is_border_vertex(v), is_border);
        const int back = mesh.find_half_edge(a, v);
        ASSERT_EQ(StellarMesh::face(back), f);
        EXPECT_TRUE(mesh.can_weld_edge(back)) << name;
        mesh.weld_edge(back);
        ASSERT_EQ(first_broken(mesh), "") << name;
        ASSERT_EQ(canonical(mesh), before) << name;
      }
    }
  }
}

TEST(StellarMesh, FaceSplitAndWeldAreInverse) {
  for (const auto& [name, zoo] : test::mesh_zoo()) {
    StellarMesh mesh = mesh_of(zoo);
    const auto before = canonical(mesh);
    for (int f = 0; f < static_cast<int>(zoo.triangle_count()); ++f) {
      const int v = mesh.split_face(f);
      ASSERT_EQ(first_broken(mesh), "") << name;
      EXPECT_TRUE(mesh.can_weld_face(v));
      mesh.weld_face(StellarMesh::half_edge(f, 0));
      ASSERT_EQ(first_broken(mesh), "") << name;
      ASSERT_EQ(canonical(mesh), before) << name;
    }
  }
}

TEST(StellarMesh, AnyOrderOfSplitsUndoneBackwardsGivesTheMeshBack) {
  for (const auto& [name, zoo] : test::mesh_zoo()) {
    StellarMesh mesh = mesh_of(zoo);
    const auto before = canonical(mesh);
    struct Step {
      bool is_edge;
      int slot, a, vertex;
    };
    std::vector<Step> steps;
    for (int k = 0; k < 200; ++k) {
      const int f = static_cast<int>(test::random().below(mesh.face_slots()));
      const int h = StellarMesh::half_edge(f, static_cast<int>(test::random().below(3)));
      const bool is_edge = test::random().below(2) == 0;
      const int a = mesh.from(h);
      steps.push_back({is_edge, f, a, is_edge ? mesh.split_edge(h) : mesh.split_face(f)});
    }
    ASSERT_EQ(first_broken(mesh), "") << name;
    while (!steps.empty()) {
      const Step step = steps.back();
      steps.pop_back();
      if (step.is_edge) {
        mesh.weld_edge(mesh.find_half_edge(step.a, step.vertex));
      } else {
        const auto& corners = mesh.corners(step.slot);
        const auto at = std::find(corners.begin(), corners.end(), step.vertex) - corners.begin();
        mesh.weld_face(mesh.next(StellarMesh::half_edge(step.slot, static_cast<int>(at))));
      }
      ASSERT_EQ(first_broken(mesh), "") << name;
    }
    EXPECT_EQ(canonical(mesh), before) << name;
  }
}

TEST(StellarMesh, StarsLinksAndBorders) {
  const StellarMesh wheel = mesh_of(test::disk(7, 1));
  EXPECT_EQ(wheel.valence(0), 7);
  EXPECT_EQ(wheel.star(0).size(), 7u);
  EXPECT_EQ(wheel.link(0).size(), 7u);
  EXPECT_EQ(wheel.link(1).size(), 3u);
  EXPECT_EQ(wheel.border_loops().size(), 1u);
  EXPECT_EQ(wheel.border_loops()[0].size(), 7u);
  EXPECT_EQ(wheel.find_half_edge(1, 4), StellarMesh::kNone);
  EXPECT_TRUE(mesh_of(test::torus(5, 5)).border_loops().empty());
}

TEST(StellarMesh, WeldThatWouldDoubleAnEdgeIsRefused) {
  const StellarMesh mesh = mesh_of(test::tetrahedron());
  for (int f = 0; f < 4; ++f) {
    for (int i = 0; i < 3; ++i) EXPECT_FALSE(mesh.can_weld_edge(StellarMesh::half_edge(f, i)));
  }
  EXPECT_TRUE(mesh.can_weld_face(0));
}

TEST(StellarMesh, RefusesWhatIsNoManifold) {
  const std::vector<Eigen::Vector3i> fan = {{0, 1, 2}, {0, 1, 3}};
  EXPECT_THROW(StellarMesh(fan, 4), InvalidInput);
}

}  // namespace
}  // namespace phiz
