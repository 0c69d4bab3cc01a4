#include "stages/subdivide/ring_normals.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "stages/geometry/angle.h"
#include "stages/geometry/normals.h"
#include "stages/subdivide/level_surface.h"
#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using Points = std::vector<Eigen::Vector3d>;

/// A zoo mesh one level up, shaken.
struct Level {
  explicit Level(const TriangleMesh& mesh)
      : hierarchy(mesh.triangles, static_cast<int>(mesh.vertex_count()), 1) {
    for (const Eigen::Vector3f& p : mesh.positions) positions.push_back(p.cast<double>());
    refine_positions(hierarchy, 1, positions);
    test::Random& random = test::random();
    for (Eigen::Vector3d& p : positions)
      p += 0.02 * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
  }
  std::size_t first() const { return hierarchy.vertex_count(0); }
  SubdivisionHierarchy hierarchy;
  Points positions;
};

/// One ring at a time, in plain scalar code.
Eigen::Vector3d plain_normal(const Points& positions, const Eigen::Vector3d& centre,
                             const SubdivisionHierarchy::Ring& ring) {
  const int count = ring[4] < 0 ? 3 : 6;
  double x = 0, y = 0, z = 0;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d a = positions[ring[i]] - centre, b = positions[ring[(i + 1) % 6]] - centre;
    const double nx = a.y() * b.z() - a.z() * b.y();
    const double ny = a.z() * b.x() - a.x() * b.z();
    const double nz = a.x() * b.y() - a.y() * b.x();
    const double length = std::sqrt(nx * nx + ny * ny + nz * nz);
    const double weight =
        length > 0 ? angle_of(length, a.x() * b.x() + a.y() * b.y() + a.z() * b.z()) / length : 0.0;
    x += weight * nx;
    y += weight * ny;
    z += weight * nz;
  }
  const double length = std::sqrt(x * x + y * y + z * z), scale = length > 0 ? 1 / length : 0.0;
  return {x * scale, y * scale, z * scale};
}

TEST(RingNormals, VectorCodeGivesTheBitsOfPlainCode) {
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    SCOPED_TRACE(name);
    const Level level(mesh);
    const Points normals = displacement_normals(level.hierarchy, 1, level.positions);
    for (std::size_t i = 0; i < normals.size(); ++i)
      EXPECT_EQ(normals[i], plain_normal(level.positions, level.positions[level.first() + i],
                                         level.hierarchy.rings(1)[i]));
  }
}

TEST(RingNormals, AgreeWithVertexNormals) {
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    SCOPED_TRACE(name);
    const Level level(mesh);
    const Points normals = displacement_normals(level.hierarchy, 1, level.positions);
    const Points expected = compute_vertex_normals(level.positions, level.hierarchy.triangles(1));
    for (std::size_t i = 0; i < normals.size(); ++i)
      EXPECT_LT((normals[i] - expected[level.first() + i]).norm(), 1e-9);
  }
}

TEST(RingNormals, AreZeroWhereNothingHasAnArea) {
  const TriangleMesh mesh = test::icosphere(0);
  const SubdivisionHierarchy hierarchy(mesh.triangles, 12, 1);
  const Points collapsed(42, Eigen::Vector3d(1, 2, 3));
  for (const Eigen::Vector3d& normal : displacement_normals(hierarchy, 1, collapsed))
    EXPECT_EQ(normal, Eigen::Vector3d::Zero());
}

}  // namespace
}  // namespace phiz
