#include "stages/fit/folds.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "stages/geometry/half_edge.h"
#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using Positions = FoldSearch::Positions;

constexpr int kCells = 14;

/// A flat grid at rest, subdivided twice.
struct Sheet {
  Sheet()
      : mesh(test::open_grid(kCells, kCells)),
        hierarchy(mesh.triangles, static_cast<int>(mesh.vertex_count()), 2),
        rest(mesh.vertex_count(), 3) {
    std::vector<Eigen::Vector3d> positions;
    for (const Eigen::Vector3f& p : mesh.positions) positions.push_back(kCells * p.cast<double>());
    for (std::size_t v = 0; v < positions.size(); ++v) rest.row(v) = positions[v].transpose();
    laplacian = normalised_laplacian(mesh.triangles, positions);
    for (const int level : {1, 2}) samples.push_back(compose_stencils(hierarchy, level));
  }
  FoldSearch search() const { return {hierarchy, samples, laplacian, rest}; }
  int nearest(double x, double y) const {
    int best = 0;
    for (Eigen::Index v = 0; v < rest.rows(); ++v)
      if ((rest.row(v).head<2>() - Eigen::RowVector2d(x, y)).norm() <
          (rest.row(best).head<2>() - Eigen::RowVector2d(x, y)).norm())
        best = static_cast<int>(v);
    return best;
  }

  TriangleMesh mesh;
  SubdivisionHierarchy hierarchy;
  Positions rest;
  StencilMatrix laplacian;
  std::vector<StencilMatrix> samples;
};

const Sheet& sheet() {
  static const Sheet sheet;
  return sheet;
}

Positions affine(const Positions& x) {
  Eigen::Matrix3d linear;
  linear << 1.2, 0.1, 0, -0.1, 0.9, 0, 0.2, -0.1, 1;
  return (x * linear.transpose()).rowwise() + Eigen::RowVector3d(3, -2, 1);
}

TEST(Folds, WithoutFoldsNothingIsTouched) {
  Positions x = affine(sheet().rest);
  test::Random& random = test::random();
  for (Eigen::Index v = 0; v < x.rows(); ++v) x(v, 2) += random.uniform(-0.1, 0.1);
  const Positions before = x;
  EXPECT_TRUE(find_folded(sheet().search(), x).empty());
  EXPECT_EQ(lay_folds_flat(sheet().search(), x), 0);
  EXPECT_EQ(x, before);
}

TEST(Folds, AFoldInAnAffineImageIsLaidBackExactly) {
  const Positions truth = affine(sheet().rest);
  Positions x = truth;
  const int centre = sheet().nearest(kCells / 2.0, kCells / 2.0);
  x.row(centre) += Eigen::RowVector3d(2.5, 0.3, 0);
  EXPECT_FALSE(find_folded(sheet().search(), x).empty());
  EXPECT_EQ(lay_folds_flat(sheet().search(), x), 0);
  EXPECT_LT((x - truth).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(Folds, WhatIsFarFromFoldsStays) {
  test::Random& random = test::random();
  for (int trial = 0; trial < 20; ++trial) {
    Positions x = affine(sheet().rest);
    const int centre = sheet().nearest(random.uniform(5, 9), random.uniform(5, 9));
    x.row(centre) += Eigen::RowVector3d(random.uniform(-4, 4), random.uniform(-4, 4), random.uniform(-4, 4));
    const Positions before = x;
    EXPECT_EQ(lay_folds_flat(sheet().search(), x, 2), 0);
    for (Eigen::Index v = 0; v < x.rows(); ++v)
      if ((sheet().rest.row(v) - sheet().rest.row(centre)).norm() > 6.5) {
        EXPECT_EQ(x.row(v), before.row(v));
      }
  }
}

TEST(Folds, AFoldOfTheSubdividedSurfaceAloneIsFound) {
  // A step whose flat triangles stay under 84 degrees; the butterfly is steeper.
  Positions x = sheet().rest;
  for (Eigen::Index v = 0; v < x.rows(); ++v)
    if (sheet().rest(v, 0) > kCells / 2.0) x(v, 2) += 9.5;
  const FoldSearch flat{sheet().hierarchy, {}, sheet().laplacian, sheet().rest};
  EXPECT_TRUE(find_folded(flat, x).empty());
  EXPECT_FALSE(find_folded(sheet().search(), x).empty());
}

TEST(Folds, NeverLeavesMoreFoldedThanItFoundAndNeverMovesTheBorder) {
  test::Random& random = test::random();
  for (int trial = 0; trial < 10; ++trial) {
    Positions x = sheet().rest;
    for (Eigen::Index v = 0; v < x.rows(); ++v)
      for (int k = 0; k < 3; ++k) x(v, k) += random.uniform(-1, 1);
    const Positions before = x;
    const std::size_t found = find_folded(sheet().search(), x).size();
    const int left = lay_folds_flat(sheet().search(), x);
    EXPECT_LE(static_cast<std::size_t>(left), found);
    EXPECT_EQ(static_cast<std::size_t>(left), find_folded(sheet().search(), x).size());
    const HalfEdgeMesh mesh(sheet().mesh.triangles, static_cast<int>(x.rows()));
    for (int v = 0; v < x.rows(); ++v)
      if (mesh.is_border_vertex(v)) {
        EXPECT_EQ(x.row(v), before.row(v));
      }
  }
}

TEST(Folds, ATriangleWithoutAnAreaAtRestIsNotFolded) {
  Sheet pinched;
  const Eigen::Vector3i t = pinched.mesh.triangles[kCells * kCells];
  pinched.rest.row(t[1]) = pinched.rest.row(t[0]);
  EXPECT_TRUE(find_folded(pinched.search(), pinched.rest).empty());
}

}  // namespace
}  // namespace phiz
