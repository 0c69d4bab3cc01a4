#include "stages/unwrap/uv_domain.h"

#include <gtest/gtest.h>

#include "stages/geometry/error.h"
#include "stages/subdivide/subdivide.h"
#include "tests/stages/unwrap/uv_samples.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using test::random_uv_square;

Eigen::Vector2d place_at(const SurfacePoint& point, const std::vector<Eigen::Vector2d>& uv,
                         const std::vector<Eigen::Vector3i>& triangles) {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  for (int i = 0; i < 3; ++i) place += point.weights[i] * uv[triangles[point.triangle_idx][i]];
  return place;
}

TEST(UvDomain, WeightsArePartitionsOfUnityAndGiveThePlaceBack) {
  const test::UvMesh mesh = random_uv_square(9);
  const UvDomain domain(mesh.uv, mesh.triangles);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d uv(test::random().uniform(), test::random().uniform());
    const SurfacePoint place = domain.locate(uv);
    EXPECT_NEAR(place.weights.sum(), 1, 1e-15);
    EXPECT_GE(place.weights.minCoeff(), 0);
    EXPECT_LT((place_at(place, mesh.uv, mesh.triangles) - uv).norm(), 1e-12);
  }
}

TEST(UvDomain, VerticesAndBordersAreExact) {
  const test::UvMesh mesh = random_uv_square(7);
  const UvDomain domain(mesh.uv, mesh.triangles);
  for (std::size_t v = 0; v < mesh.uv.size(); ++v) {
    const SurfacePoint place = domain.locate(mesh.uv[v]);
    int corner = -1;
    place.weights.maxCoeff(&corner);
    EXPECT_EQ(place.weights[corner], 1);
    EXPECT_EQ(mesh.triangles[place.triangle_idx][corner], static_cast<int>(v));
  }
  for (int i = 0; i < 200; ++i) {
    const double t = test::random().uniform();
    for (const Eigen::Vector2d& uv :
         {Eigen::Vector2d(t, 0), Eigen::Vector2d(t, 1), Eigen::Vector2d(0, t), Eigen::Vector2d(1, t)}) {
      const SurfacePoint place = domain.locate(uv);
      for (int corner = 0; corner < 3; ++corner) {  // only vertices of that border take part
        if (place.weights[corner] == 0) continue;
        const Eigen::Vector2d vertex = mesh.uv[mesh.triangles[place.triangle_idx][corner]];
        const bool is_vertical = uv.x() == 0 || uv.x() == 1;
        EXPECT_EQ(is_vertical ? vertex.x() : vertex.y(), is_vertical ? uv.x() : uv.y());
      }
    }
  }
}

TEST(UvDomain, PlacesBeyondTheSquareAreThoseOfItsBorder) {
  const test::UvMesh mesh = random_uv_square(3);
  const UvDomain domain(mesh.uv, mesh.triangles);
  const auto at = [&](double u, double v) {
    return place_at(domain.locate({u, v}), mesh.uv, mesh.triangles);
  };
  EXPECT_LT((at(-4, 0.3) - Eigen::Vector2d(0, 0.3)).norm(), 1e-15);
  EXPECT_LT((at(2, 9) - Eigen::Vector2d(1, 1)).norm(), 1e-15);
  EXPECT_NO_THROW(domain.locate({std::nan(""), 0.5}));
}

TEST(UvDomain, RefinedPlacesAreTheSamePlace) {
  const test::UvMesh mesh = random_uv_square(4);
  const UvDomain domain(mesh.uv, mesh.triangles);
  const SubdivisionHierarchy hierarchy(mesh.triangles, static_cast<int>(mesh.uv.size()), 4);
  for (int level = 0; level <= 4; ++level) {
    const std::vector<Eigen::Vector2d> uv = evaluate_uv(hierarchy, mesh.uv, level);
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector2d wanted(test::random().uniform(), test::random().uniform());
      const SurfacePoint place = refine_place(domain.locate(wanted), level);
      EXPECT_GE(place.weights.minCoeff(), 0);
      EXPECT_LT((place_at(place, uv, hierarchy.triangles(level)) - wanted).norm(), 1e-12);
    }
  }
}

TEST(UvDomain, RefusesWhatIsNoChartOfTheSquare) {
  test::UvMesh mesh = random_uv_square(3);
  std::swap(mesh.triangles[4][0], mesh.triangles[4][1]);
  EXPECT_THROW(UvDomain(mesh.uv, mesh.triangles), InvalidInput);
  mesh = random_uv_square(3);
  mesh.triangles.pop_back();
  EXPECT_THROW(UvDomain(mesh.uv, mesh.triangles), InvalidInput);
  mesh = random_uv_square(3);
  mesh.triangles[0][0] = 99;
  EXPECT_THROW(UvDomain(mesh.uv, mesh.triangles), InvalidInput);
}

}  // namespace
}  // namespace phiz
