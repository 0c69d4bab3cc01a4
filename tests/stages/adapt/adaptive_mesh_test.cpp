#include "stages/adapt/adaptive_mesh.h"

#include <gtest/gtest.h>

#include <map>

#include "stages/adapt/compliance.h"
#include "tests/support/mesh_zoo.h"

namespace phiz {
namespace {

/// The unit sphere over an icosahedron; (u,v) are of no use there and stay on a plane grid's corners.
class SphereSurface final : public AdaptiveSurface {
 public:
  explicit SphereSurface(double tolerance) : tolerance_(tolerance) {
    const TriangleMesh ico = test::icosphere(0);
    std::vector<Eigen::Vector3d> positions;
    for (const Eigen::Vector3f& p : ico.positions) positions.push_back(p.cast<double>());
    base_.triangles = make_compliant(ico.triangles, positions).triangles;
    base_.uv.resize(positions.size());
    base_.attribute_count = 1;
    for (std::size_t v = 0; v < positions.size(); ++v) {
      places_[static_cast<int>(v)] = ico.positions[v];
      base_.attributes.push_back(ico.positions[v].x());
    }
  }
  const BasePolyhedron& base() const override { return base_; }
  VertexSample sample(const AdaptiveMesh& mesh, const NewVertex& place) override {
    if (place.a < 0) return {places_.at(place.vertex), places_.at(place.vertex)};
    const Eigen::Vector3f p = (mesh.position(place.a) + mesh.position(place.b)).normalized();
    places_[place.vertex] = p;
    return {p, p};
  }
  bool should_refine(const AdaptiveMesh& mesh, int f) override { return error(mesh, f) > tolerance_; }
  bool may_simplify(const AdaptiveMesh& mesh, const StellarChange& weld) override {
    return weld_error(mesh, weld) <= 0.8 * tolerance_;
  }
  double error(const AdaptiveMesh& mesh, int f) override {
    const auto& [a, b, c] = mesh.mesh().corners(f);
    return sag(mesh, a, b, c);
  }
  double weld_error(const AdaptiveMesh& mesh, const StellarChange& w) override {
    return std::max(sag(mesh, w.a, w.b, w.c), sag(mesh, w.b, w.a, w.d));
  }
  void set_tolerance(double tolerance) { tolerance_ = tolerance; }

 private:
  static double sag(const AdaptiveMesh& mesh, int a, int b, int c) {
    return 1 - (mesh.position(a) + mesh.position(b) + mesh.position(c)).norm() / 3;
  }
  double tolerance_;
  BasePolyhedron base_;
  std::map<int, Eigen::Vector3f> places_;
};

double worst_error(const AdaptiveMesh& mesh, SphereSurface& surface) {
  double worst = 0;
  for (int f = 0; f < mesh.mesh().face_slots(); ++f)
    if (mesh.mesh().is_face(f)) worst = std::max(worst, surface.error(mesh, f));
  return worst;
}

std::string first_broken(const AdaptiveMesh& mesh) {
  const std::vector<std::string> broken = mesh.triangulation().validate();
  return broken.empty() ? "" : broken.front();
}

TEST(AdaptiveMesh, RefinesUntilTheSurfaceIsContentAndTakesItBack) {
  SphereSurface surface(0.01);
  AdaptiveMesh mesh(surface);
  const TriangleMesh base = mesh.to_triangle_mesh();
  EXPECT_TRUE(mesh.refine().is_done);
  EXPECT_EQ(first_broken(mesh), "");
  EXPECT_LE(worst_error(mesh, surface), 0.01);
  const int fine = mesh.mesh().vertex_count();
  surface.set_tolerance(0.05);
  const AdaptReport coarser = mesh.adapt();
  EXPECT_GT(coarser.welds, 0);
  EXPECT_LT(mesh.mesh().vertex_count(), fine);
  EXPECT_LE(worst_error(mesh, surface), 0.05);
  const AdaptReport again = mesh.adapt();
  EXPECT_EQ(again.splits + again.welds, 0) << "not a fixed point";
  mesh.simplify_all();
  EXPECT_EQ(mesh.to_triangle_mesh().triangles, base.triangles);
  EXPECT_EQ(mesh.to_triangle_mesh().positions, base.positions);
}

TEST(AdaptiveMesh, BudgetsEndIt) {
  SphereSurface surface(1e-5);
  AdaptiveMesh mesh(surface);
  AdaptBudget budget;
  budget.vertices = 500;
  EXPECT_FALSE(mesh.refine(budget).is_done);
  EXPECT_GE(mesh.mesh().vertex_count(), 500);
  EXPECT_LT(mesh.mesh().vertex_count(), 530);
  int asked = 0;
  budget.vertices = 1 << 30;
  budget.keep_going = [&asked] { return ++asked < 3; };
  EXPECT_FALSE(mesh.refine(budget).is_done);
  EXPECT_EQ(asked, 3);
  EXPECT_EQ(first_broken(mesh), "");
}

TEST(AdaptiveMesh, InOrderIsNoWorseThanTheSameNumberByThreshold) {
  SphereSurface surface(0.004);
  AdaptiveMesh by_threshold(surface);
  by_threshold.refine();
  SphereSurface other(0.004);
  AdaptiveMesh in_order(other);
  AdaptBudget budget;
  budget.vertices = by_threshold.mesh().vertex_count();
  in_order.refine_in_order(budget);
  EXPECT_LE(in_order.mesh().vertex_count(), budget.vertices + 8);
  EXPECT_LE(worst_error(in_order, other), worst_error(by_threshold, surface) * 1.0001);
  EXPECT_EQ(first_broken(in_order), "");
}

TEST(AdaptiveMesh, AttributesAreMeansAndChangesAreListed) {
  SphereSurface surface(0.02);
  AdaptiveMesh mesh(surface);
  const AdaptReport report = mesh.refine();
  EXPECT_EQ(static_cast<int>(mesh.changes().size()), report.splits);
  for (const StellarChange& change : mesh.changes())
    EXPECT_EQ(mesh.attribute(change.vertex, 0),
              0.5f * (mesh.attribute(change.a, 0) + mesh.attribute(change.b, 0)));
}

}  // namespace
}  // namespace phiz
