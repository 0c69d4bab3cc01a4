#include "stages/adapt/multi_triangulation.h"

#include <gtest/gtest.h>

#include "stages/adapt/compliance.h"
#include "stages/geometry/error.h"
#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

CompliantMesh compliant(const TriangleMesh& mesh, BlockOrder order = BlockOrder::kMatching) {
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3f& p : mesh.positions) positions.push_back(p.cast<double>());
  return make_compliant(mesh.triangles, positions, order);
}

std::string first_broken(const MultiTriangulation& mesh) {
  const std::vector<std::string> broken = mesh.validate();
  return broken.empty() ? "" : broken.front();
}

/// Takes every vertex away again, in whatever order they come.
void simplify_all(MultiTriangulation& triangulation) {
  for (int v = triangulation.base_vertex_count(); v < triangulation.mesh().vertex_slots(); ++v) {
    if (triangulation.mesh().is_vertex(v)) triangulation.simplify(v, [](const StellarChange&) {});
  }
}

void expect_base(const MultiTriangulation& triangulation, const std::vector<Eigen::Vector3i>& base) {
  ASSERT_EQ(triangulation.mesh().face_count(), static_cast<int>(base.size()));
  EXPECT_EQ(triangulation.mesh().vertex_count(), triangulation.base_vertex_count());
  for (std::size_t f = 0; f < base.size(); ++f) {
    for (int i = 0; i < 3; ++i) ASSERT_EQ(triangulation.mesh().corners(static_cast<int>(f))[i], base[f][i]);
  }
}

TEST(MultiTriangulation, RandomWalkStaysValidAndReturnsToTheBase) {
  for (const BlockOrder order : {BlockOrder::kMatching, BlockOrder::kLongestFirst}) {
    for (const auto& [name, zoo] : test::mesh_zoo()) {
      const CompliantMesh base = compliant(zoo, order);
      MultiTriangulation walk(base.triangles, base.vertex_count);
      const auto nothing = [](const StellarChange&) {};
      for (int step = 0; step < 4000; ++step) {
        const bool is_refining = test::random().below(1000) < (walk.mesh().face_count() < 800 ? 600u : 400u);
        if (is_refining) {
          const int f = static_cast<int>(test::random().below(walk.mesh().face_slots()));
          if (walk.mesh().is_face(f) && walk.level(f) < MultiTriangulation::kMostLevel)
            walk.refine(f, nothing);
        } else {
          const int v = static_cast<int>(test::random().below(walk.mesh().vertex_slots()));
          if (walk.mesh().is_vertex(v) && walk.vertex_level(v) > 0) walk.simplify(v, nothing);
        }
        if (step % 100 == 0) {
          ASSERT_EQ(first_broken(walk), "") << name << " after " << step;
        }
      }
      simplify_all(walk);
      ASSERT_EQ(first_broken(walk), "") << name;
      expect_base(walk, base.triangles);
    }
  }
}

TEST(MultiTriangulation, EveryChangeCanBeReplayedOnAnIndexList) {
  const CompliantMesh base = compliant(test::icosphere(1));
  MultiTriangulation mesh(base.triangles, base.vertex_count);
  std::vector<std::array<int, 3>> faces;
  for (const Eigen::Vector3i& t : base.triangles) faces.push_back({t[0], t[1], t[2]});
  const auto replay = [&](const StellarChange& s) {
    const auto put = [&](int f, std::array<int, 3> corners) {
      if (f < 0) return;
      if (f >= static_cast<int>(faces.size())) faces.resize(f + 1);
      faces[f] = corners;
    };
    if (s.is_split) {
      put(s.f, {s.c, s.a, s.vertex}), put(s.n, {s.b, s.c, s.vertex});
      put(s.g, {s.d, s.b, s.vertex}), put(s.m, {s.a, s.d, s.vertex});
    } else {
      put(s.f, {s.a, s.b, s.c}), put(s.g, {s.b, s.a, s.d});
      put(s.n, {}), put(s.m, {});
    }
  };
  for (int step = 0; step < 3000; ++step) {
    if (test::random().below(10) < 6) {
      const int f = static_cast<int>(test::random().below(mesh.mesh().face_slots()));
      if (mesh.mesh().is_face(f)) mesh.refine(f, replay);
    } else {
      const int v = static_cast<int>(test::random().below(mesh.mesh().vertex_slots()));
      if (mesh.mesh().is_vertex(v) && mesh.vertex_level(v) > 0) mesh.simplify(v, replay);
    }
  }
  for (int f = 0; f < mesh.mesh().face_slots(); ++f) {
    if (mesh.mesh().is_face(f)) {
      ASSERT_EQ(faces[f], mesh.mesh().corners(f));
    }
  }
}

TEST(MultiTriangulation, LevelsInterleave) {
  const CompliantMesh base = compliant(test::torus(6, 4));
  MultiTriangulation mesh(base.triangles, base.vertex_count);
  for (int level = 0; level < 6; ++level) {
    const int slots = mesh.mesh().face_slots();
    for (int f = 0; f < slots; ++f)
      if (mesh.level(f) == level) mesh.refine(f, [](const StellarChange&) {});
    EXPECT_EQ(mesh.mesh().face_count(), static_cast<int>(base.triangles.size()) << (level + 1));
    EXPECT_EQ(first_broken(mesh), "");
  }
  EXPECT_LE(mesh.mesh().memory_bytes(), 96u * mesh.mesh().face_count());
}

TEST(MultiTriangulation, RefusesABaseWithoutBlocks) {
  EXPECT_THROW(MultiTriangulation(std::vector<Eigen::Vector3i>{{1, 2, 0}, {1, 3, 2}}, 4), InvalidInput);
  EXPECT_NO_THROW(MultiTriangulation(std::vector<Eigen::Vector3i>{{1, 2, 0}, {2, 1, 3}}, 4));
  EXPECT_NO_THROW(MultiTriangulation(std::vector<Eigen::Vector3i>{{0, 1, 2}, {1, 3, 2}}, 4));
}

}  // namespace
}  // namespace phiz
