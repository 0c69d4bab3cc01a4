#include "stages/geometry/half_edge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "stages/geometry/error.h"
#include "tests/support/mesh_zoo.h"

namespace phiz {
namespace {

HalfEdgeMesh connect(const TriangleMesh& mesh) {
  return HalfEdgeMesh(mesh.triangles, static_cast<int>(mesh.vertex_count()));
}

std::string refusal(const std::vector<Eigen::Vector3i>& triangles, int vertex_count) {
  try {
    HalfEdgeMesh mesh(triangles, vertex_count);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

int euler_characteristic(const TriangleMesh& mesh) {
  std::set<int> used;
  for (const Eigen::Vector3i& t : mesh.triangles) used.insert({t[0], t[1], t[2]});
  const HalfEdgeMesh half_edges = connect(mesh);
  return static_cast<int>(used.size()) - half_edges.edge_count() + half_edges.triangle_count();
}

TEST(HalfEdgeMesh, TwinsAndTurnsAreInversesOnTheMeshZoo) {
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    SCOPED_TRACE(name);
    const HalfEdgeMesh m = connect(mesh);
    for (int h = 0; h < m.half_edge_count(); ++h) {
      EXPECT_EQ(m.next(m.next(m.next(h))), h);
      EXPECT_EQ(m.prev(m.next(h)), h);
      EXPECT_EQ(m.from(h), mesh.triangles[m.triangle(h)][h % 3]);
      EXPECT_EQ(m.to(h), m.from(m.next(h)));
      if (m.is_border_edge(h)) continue;
      EXPECT_EQ(m.twin(m.twin(h)), h);
      EXPECT_EQ(m.from(m.twin(h)), m.to(h));
      EXPECT_EQ(m.to(m.twin(h)), m.from(h));
      EXPECT_EQ(m.edge(m.twin(h)), m.edge(h));
    }
  }
}

TEST(HalfEdgeMesh, EdgesAreNumberedByTheirFirstHalfEdge) {
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    SCOPED_TRACE(name);
    const HalfEdgeMesh m = connect(mesh);
    int next_edge = 0;
    for (int h = 0; h < m.half_edge_count(); ++h) {
      const bool first = m.is_border_edge(h) || h < m.twin(h);
      if (first) {
        EXPECT_EQ(m.edge(h), next_edge++);
      }
    }
    EXPECT_EQ(next_edge, m.edge_count());
  }
}

TEST(HalfEdgeMesh, EulerCharacteristicNamesTheSurface) {
  EXPECT_EQ(euler_characteristic(test::tetrahedron()), 2);
  EXPECT_EQ(euler_characteristic(test::icosphere(2)), 2);
  EXPECT_EQ(euler_characteristic(test::torus(12, 7)), 0);
  EXPECT_EQ(euler_characteristic(test::open_grid(5, 3)), 1);
  EXPECT_EQ(euler_characteristic(test::disk(9, 2)), 1);
}

TEST(HalfEdgeMesh, RingsGoRoundTheVertexInTheSenseOfItsTriangles) {
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    SCOPED_TRACE(name);
    const HalfEdgeMesh m = connect(mesh);
    std::set<std::vector<int>> triangles;
    for (Eigen::Vector3i t : mesh.triangles) {
      std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
      triangles.insert({t[0], t[1], t[2]});
    }
    for (int v = 0; v < m.vertex_count(); ++v) {
      const std::vector<int> ring = m.ring(v);
      ASSERT_EQ(static_cast<int>(ring.size()), m.valence(v));
      const std::size_t fan = m.is_border_vertex(v) ? ring.size() - 1 : ring.size();
      EXPECT_EQ(fan, static_cast<std::size_t>(
                         std::count_if(mesh.triangles.begin(), mesh.triangles.end(),
                                       [v](const Eigen::Vector3i& t) { return (t.array() == v).any(); })));
      for (std::size_t i = 0; i < fan; ++i) {
        Eigen::Vector3i t(v, ring[i], ring[(i + 1) % ring.size()]);
        std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
        EXPECT_TRUE(triangles.count({t[0], t[1], t[2]})) << "vertex " << v << ", step " << i;
      }
    }
  }
}

TEST(HalfEdgeMesh, BorderLoopsHoldEveryBorderVertexOnce) {
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    SCOPED_TRACE(name);
    const HalfEdgeMesh m = connect(mesh);
    std::vector<int> seen(m.vertex_count(), 0);
    for (const std::vector<int>& loop : m.border_loops())
      for (std::size_t i = 0; i < loop.size(); ++i) {
        ++seen[loop[i]];
        EXPECT_EQ(m.to(m.outgoing(loop[i])), loop[(i + 1) % loop.size()]);
      }
    for (int v = 0; v < m.vertex_count(); ++v) EXPECT_EQ(seen[v], m.is_border_vertex(v) ? 1 : 0);
  }
  EXPECT_EQ(connect(test::open_grid(5, 3)).border_loops().size(), 1u);
  EXPECT_EQ(connect(test::open_grid(5, 3)).border_loops()[0].size(), 16u);
  EXPECT_TRUE(connect(test::torus(12, 7)).border_loops().empty());
}

TEST(HalfEdgeMesh, IsolatedVerticesAreAllowed) {
  const HalfEdgeMesh m(std::vector<Eigen::Vector3i>{{0, 2, 4}}, 6);
  EXPECT_EQ(m.outgoing(1), HalfEdgeMesh::kNone);
  EXPECT_EQ(m.valence(1), 0);
  EXPECT_TRUE(m.ring(5).empty());
  EXPECT_FALSE(m.is_border_vertex(3));
  EXPECT_EQ(HalfEdgeMesh({}, 0).vertex_count(), 0);
}

TEST(HalfEdgeMesh, RefusesWhatIsNoManifoldAndNamesThePlace) {
  EXPECT_EQ(refusal({{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}, 5), "edge 0-1 has 3 triangles, at most 2 are allowed");
  EXPECT_EQ(refusal({{0, 1, 2}, {1, 0, 3}, {1, 0, 4}}, 5), "edge 0-1 has 3 triangles, at most 2 are allowed");
  EXPECT_EQ(refusal({{0, 1, 2}, {0, 1, 3}}, 4), "triangles 0 and 1 disagree in orientation along edge 0-1");
  EXPECT_EQ(refusal({{0, 1, 2}, {2, 3, 4}}, 5), "the triangles at vertex 2 form more than one fan");
  EXPECT_EQ(refusal({{0, 1, 2}, {0, 3, 0}}, 5), "triangle 1 names a vertex twice");
  EXPECT_EQ(refusal({{0, 1, 2}, {0, 2, 5}}, 5), "triangle 1 refers to a vertex that is not there");
  EXPECT_EQ(refusal({{0, -1, 2}}, 5), "triangle 0 refers to a vertex that is not there");
  EXPECT_EQ(refusal({{0, 1, 2}, {0, 1, 2}}, 3), "triangles 0 and 1 disagree in orientation along edge 0-1");
}

TEST(HalfEdgeMesh, RefusesTwoClosedSurfacesThatTouchInAVertex) {
  const TriangleMesh one = test::tetrahedron();
  std::vector<Eigen::Vector3i> both = one.triangles;
  for (const Eigen::Vector3i& t : one.triangles)
    both.push_back(t.unaryExpr([](int v) { return v == 0 ? 0 : v + 3; }));
  EXPECT_EQ(refusal(both, 7), "the triangles at vertex 0 form more than one fan");
}

TEST(HalfEdgeMesh, AVertexOfVeryManyTrianglesIsNoTrouble) {
  const TriangleMesh mesh = test::disk(60000, 1);
  EXPECT_EQ(connect(mesh).valence(0), 60000);
}

}  // namespace
}  // namespace phiz
