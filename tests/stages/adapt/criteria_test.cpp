#include "stages/adapt/criteria.h"

#include <gtest/gtest.h>

#include <cmath>

#include "stages/adapt/base_mesh.h"
#include "stages/geometry/error.h"
#include "stages/geometry/normals.h"
#include "tests/support/mesh_zoo.h"

namespace phiz {
namespace {

/// A hill over the square, 100 mm wide: flat but for a bump of 20 mm at (0.7, 0.6).
Eigen::Vector3d hill(const Eigen::Vector2d& uv) {
  const double squared = (uv - Eigen::Vector2d(0.7, 0.6)).squaredNorm();
  return {100 * uv.x(), 100 * uv.y(), 20 * std::exp(-squared / 0.01)};
}

struct Hill {
  Hill() : chart(make_chart()) {
    std::vector<Eigen::Vector3d> exact;
    for (const Eigen::Vector2d& uv : chart.uv) exact.push_back(hill(uv));
    for (const Eigen::Vector3d& p : exact) positions.push_back(p.cast<float>());
    for (const Eigen::Vector3d& n : compute_vertex_normals(exact, chart.hierarchy.triangles(chart.level)))
      normals.push_back(n.cast<float>());
    points = select_surface_points(chart, positions, 0.001);
    BaseLayout layout;
    for (int i = 0; i < 16; ++i) {
      layout.uv.emplace_back((i % 4) / 3.0, (i / 4) / 3.0);
      layout.names.push_back(std::string("p").append(std::to_string(i)));
    }
    const auto triangles = triangulate_layout(layout);
    std::vector<Eigen::Vector3d> places;
    for (const Eigen::Vector2d& uv : layout.uv) places.push_back(hill(uv));
    base = make_base(layout.uv, triangles, places);
  }
  static UvChart make_chart() {
    const TriangleMesh grid = test::open_grid(8, 8);
    std::vector<Eigen::Vector2d> uv;
    for (const Eigen::Vector3f& p : grid.positions) uv.push_back(p.head<2>().cast<double>());
    return make_uv_chart(uv, grid.triangles, 4);
  }
  /// The largest distance of surface and mesh at the same (u,v), by looking everywhere.
  double gap(const AdaptiveMesh& mesh) const {
    const TriangleMesh made = mesh.to_triangle_mesh();
    std::vector<Eigen::Vector2d> uv;
    for (const Eigen::Vector2f& place : made.uv) uv.push_back(place.cast<double>());
    const UvDomain domain(uv, made.triangles);
    double worst = 0;
    for (std::size_t i = 0; i < chart.uv.size(); ++i) {
      const SurfacePoint p = domain.locate(chart.uv[i]);
      Eigen::Vector3f there = Eigen::Vector3f::Zero();
      for (int k = 0; k < 3; ++k)
        there += static_cast<float>(p.weights[k]) * made.positions[made.triangles[p.triangle_idx][k]];
      worst = std::max(worst, static_cast<double>((there - positions[i]).norm()));
    }
    return worst;
  }
  UvChart chart;
  std::vector<Eigen::Vector3f> positions, normals;
  SurfacePoints points;
  MadeBase base;
};

const Hill& the_hill() {
  static const Hill hill_once;
  return hill_once;
}

int refine(const CriterionOptions& options, double* gap = nullptr) {
  const Hill& world = the_hill();
  LevelSampler sampler(world.chart, world.positions, world.normals);
  CriterionSurface surface(world.base.polyhedron, sampler, world.points, options);
  AdaptiveMesh mesh(surface);
  mesh.refine();
  EXPECT_TRUE(mesh.validate().empty());
  if (gap != nullptr) *gap = world.gap(mesh);
  return mesh.mesh().vertex_count();
}

TEST(Criteria, ContourKeepsItsToleranceEverywhere) {
  for (const double tolerance : {4.0, 1.0, 0.25}) {
    CriterionOptions options;
    options.tolerance = tolerance;
    double gap = 0;
    refine(options, &gap);
    EXPECT_LE(gap, tolerance + 0.005);
    EXPECT_GT(gap, 0.2 * tolerance);
  }
}

TEST(Criteria, EveryCriterionNeedsFewerVerticesThanUniformForItsError) {
  CriterionOptions uniform;
  uniform.criterion = Criterion::kUniform;
  uniform.depth = 6;
  double error = 0;
  const int all = refine(uniform, &error);
  for (const Criterion criterion : {Criterion::kContour, Criterion::kDistance, Criterion::kNormals}) {
    CriterionOptions options;
    options.criterion = criterion;
    options.first_level = 2;
    options.tolerance = (criterion == Criterion::kNormals ? 0.5 : 0.95) * error;
    double gap = 0;
    const int vertices = refine(options, &gap);
    EXPECT_LT(vertices, all / 2);
    EXPECT_LE(gap, criterion == Criterion::kContour ? error : 1.6 * error);
  }
}

TEST(Criteria, UniformDoublesFacesALevel) {
  for (int depth = 0; depth < 5; ++depth) {
    const Hill& world = the_hill();
    CriterionOptions options;
    options.criterion = Criterion::kUniform;
    options.depth = depth;
    LevelSampler sampler(world.chart, world.positions, world.normals);
    CriterionSurface surface(world.base.polyhedron, sampler, world.points, options);
    AdaptiveMesh mesh(surface);
    mesh.refine();
    EXPECT_EQ(mesh.mesh().face_count(), 18 << depth);
  }
}

TEST(Criteria, PointsFollowSplitsAndWelds) {
  const Hill& world = the_hill();
  CriterionOptions options;
  options.tolerance = 0.3;
  LevelSampler sampler(world.chart, world.positions, world.normals);
  CriterionSurface surface(world.base.polyhedron, sampler, world.points, options);
  AdaptiveMesh mesh(surface);
  mesh.refine();
  options.tolerance = 2;
  surface.set_options(options);
  mesh.resample();
  EXPECT_GT(mesh.adapt().welds, 0);
  EXPECT_LE(world.gap(mesh), 2.005);
  mesh.simplify_all();
  std::vector<double> before;
  for (int f = 0; f < mesh.mesh().face_slots(); ++f)
    if (mesh.mesh().is_face(f)) before.push_back(surface.error(mesh, f));
  CriterionSurface fresh(world.base.polyhedron, sampler, world.points, options);
  AdaptiveMesh other(fresh);
  ASSERT_EQ(before.size(), world.base.polyhedron.triangles.size());
  for (int f = 0; f < static_cast<int>(before.size()); ++f)
    EXPECT_EQ(before[f], fresh.error(other, f)) << "a face has other points than at first";
}

TEST(Criteria, WhatLooksAwayIsCoarser) {
  CriterionOptions options;
  options.tolerance = 1;
  options.view = AdaptView{{70, 60, 300}, 300, 1, 0.15f};
  const int seen = refine(options);
  options.view->eye_mm = {70, 60, -300};
  EXPECT_LT(refine(options), seen);
}

TEST(Base, LayoutsThatCannotBeAreRefusedByName) {
  BaseLayout layout;
  layout.uv = {{0, 0}, {1, 0}, {1, 1}};
  layout.names = {"a", "b", "c"};
  EXPECT_THROW(triangulate_layout(layout), InvalidInput);
  layout.uv.emplace_back(0, 1);
  layout.names.push_back("d");
  EXPECT_EQ(triangulate_layout(layout).size(), 2u);
  layout.edges = {{0, 2}, {1, 3}};
  EXPECT_THROW(triangulate_layout(layout), InvalidInput);
  layout.edges = {{1, 3}};
  for (const Eigen::Vector3i& t : triangulate_layout(layout)) EXPECT_NE(t, Eigen::Vector3i(0, 1, 2));
}

}  // namespace
}  // namespace phiz
