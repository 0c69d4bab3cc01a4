#include "stages/geometry/annotations.h"

#include <gtest/gtest.h>

namespace phiz {
namespace {

/// A strip of squares along x: vertices 0 1 | 2 3 | 4 5 | ...
ControlMesh make_strip(int squares) {
  ControlMesh mesh;
  for (int i = 0; i <= squares; ++i)
    for (const double y : {0.0, 1.0}) mesh.positions.emplace_back(i, y, 0);
  for (int i = 0; i < squares; ++i) {
    mesh.triangles.emplace_back(2 * i, 2 * i + 2, 2 * i + 1);
    mesh.triangles.emplace_back(2 * i + 1, 2 * i + 2, 2 * i + 3);
  }
  return mesh;
}

TEST(FindHidden, NothingIsWhereNothingIsAnnotated) {
  const ControlMesh mesh = make_strip(3);
  EXPECT_EQ(find_hidden(mesh), std::vector<char>(8, 0));
}

TEST(FindHidden, ConstrainedVerticesTheirNeighboursAndTheEyes) {
  ControlMesh mesh = make_strip(5);
  mesh.annotations.constrained_vertices = {2};
  mesh.annotations.regions["eyes"] = {10};
  mesh.annotations.regions["eyelids"] = {9, 10, 11};
  //                                              0  1  2  3  4  5  6  7  8  9 10 11
  EXPECT_EQ(find_hidden(mesh), (std::vector<char>{1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 1, 0}));
}

TEST(FindUnmeasurable, AddsTheEdgesOfLids) {
  ControlMesh mesh = make_strip(5);
  mesh.annotations.constrained_vertices = {2};
  EXPECT_EQ(find_unmeasurable(mesh), find_hidden(mesh));
  mesh.annotations.regions["eyelids"] = {2, 3, 4, 5, 6};
  //                                                    0  1  2  3  4  5  6  7  8  9 10 11
  EXPECT_EQ(find_unmeasurable(mesh), (std::vector<char>{1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0}));
}

}  // namespace
}  // namespace phiz
