#include "formats/level_topology.h"

#include <gtest/gtest.h>

#include <set>

#include "formats/error.h"
#include "stages/subdivide/subdivide.h"
#include "tests/support/mesh_zoo.h"

namespace phiz {
namespace {

/// The decoder's numbering of vertices is that of the surface it is decoded for.
TEST(LevelTopology, NumbersVerticesAsTheHierarchyDoes) {
  const TriangleMesh disk = test::disk(7, 4);
  const SubdivisionHierarchy hierarchy(disk.triangles, static_cast<int>(disk.vertex_count()), 4);
  LevelTopology level(disk.triangles, disk.vertex_count());
  EXPECT_TRUE(level.is_control());
  for (int k = 1; k <= 4; ++k) {
    EXPECT_EQ(level.next_vertex_count(), static_cast<std::size_t>(hierarchy.vertex_count(k)));
    level = level.next();
    ASSERT_EQ(level.vertex_count(), static_cast<std::size_t>(hierarchy.vertex_count(k)));
    ASSERT_EQ(level.first_new(), static_cast<std::size_t>(hierarchy.vertex_count(k - 1)));
    for (std::size_t i = 0; i < level.new_count(); ++i) {
      const SubdivisionHierarchy::Ring& ring = hierarchy.rings(k)[i];
      EXPECT_EQ(level.parents(i), (std::array<int, 2>{ring[3], ring[0]}));
      std::set<int> beside;
      for (const int r : {1, 2, 4, 5}) {
        const int v = ring[static_cast<std::size_t>(r)] - static_cast<int>(level.first_new());
        if (v >= 0 && v < static_cast<int>(i)) beside.insert(v);
      }
      const std::span<const int> earlier = level.earlier(i);
      EXPECT_EQ(std::set<int>(earlier.begin(), earlier.end()), beside);
    }
  }
}

TEST(LevelTopology, RefusesWhatIsNoOrientedSurface) {
  const auto make = [](std::vector<Eigen::Vector3i> triangles) { LevelTopology(triangles, 5); };
  EXPECT_THROW(make({{0, 1, 5}}), FormatError);
  EXPECT_THROW(make({{0, -1, 2}}), FormatError);
  EXPECT_THROW(make({{0, 1, 1}}), FormatError);
  EXPECT_THROW(make({{0, 1, 2}, {0, 1, 3}}), FormatError);
  EXPECT_THROW(make({{0, 1, 2}, {1, 0, 3}, {1, 0, 4}}), FormatError);
}

}  // namespace
}  // namespace phiz
