#include "stages/fit/sampling.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using test::random;

std::vector<Eigen::Vector3d> random_positions(std::size_t count) {
  std::vector<Eigen::Vector3d> positions;
  for (std::size_t i = 0; i < count; ++i)
    positions.emplace_back(random().normal(), random().normal(), random().normal());
  return positions;
}

std::vector<Eigen::Vector3d> doubles(const std::vector<Eigen::Vector3f>& positions) {
  std::vector<Eigen::Vector3d> result;
  for (const auto& p : positions) result.push_back(p.cast<double>());
  return result;
}

TEST(Sampling, ComposedStencilsGiveTheEvaluatedSurface) {
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    const int count = static_cast<int>(mesh.positions.size());
    const SubdivisionHierarchy hierarchy(mesh.triangles, count, 3);
    const auto control = random_positions(mesh.positions.size());
    Eigen::MatrixXd x(count, 3);
    for (int v = 0; v < count; ++v) x.row(v) = control[v].transpose();
    for (int level = 0; level <= 3; ++level) {
      const StencilMatrix stencils = compose_stencils(hierarchy, level);
      ASSERT_EQ(stencils.rows(), hierarchy.vertex_count(level)) << name;
      ASSERT_EQ(stencils.cols(), count) << name;
      const auto expected = evaluate_surface(hierarchy, control, {}, level);
      const Eigen::MatrixXd at = stencils * x;
      for (int v = 0; v < hierarchy.vertex_count(level); ++v)
        ASSERT_LT((at.row(v).transpose() - expected[v]).norm(), 1e-12) << name << " level " << level;
      EXPECT_LT((stencils * Eigen::VectorXd::Ones(count) - Eigen::VectorXd::Ones(stencils.rows())).norm(),
                1e-10)
          << name;
    }
  }
}

TEST(Sampling, LaplacianRowsSumToZeroAndNameOnlyNeighbours) {
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    const int count = static_cast<int>(mesh.positions.size());
    const StencilMatrix laplacian = normalised_laplacian(mesh.triangles, doubles(mesh.positions));
    Eigen::MatrixXi joined = Eigen::MatrixXi::Identity(count, count);
    for (const auto& t : mesh.triangles)
      for (int i = 0; i < 3; ++i) joined(t[i], t[(i + 1) % 3]) = joined(t[(i + 1) % 3], t[i]) = 1;
    EXPECT_LT((laplacian * Eigen::VectorXd::Ones(count)).cwiseAbs().maxCoeff(), 1e-12) << name;
    for (int v = 0; v < count; ++v)
      for (StencilMatrix::InnerIterator it(laplacian, v); it; ++it) {
        EXPECT_TRUE(joined(v, it.col())) << name;
        EXPECT_TRUE(it.col() == v ? it.value() == 1 : it.value() < 0) << name;
      }
  }
}

TEST(Sampling, LaplacianOfLinearFunctionsVanishesInsideAFlatPatch) {
  const TriangleMesh mesh = test::open_grid(9, 7);
  const StencilMatrix even = normalised_laplacian(mesh.triangles, doubles(mesh.positions));
  const Eigen::Vector3d slope(1.3, -0.7, 0.2);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Eigen::Vector3d p = mesh.positions[v].cast<double>();
    const bool inside = p.x() > 0.01 && p.x() < 0.99 && p.y() > 0.01 && p.y() < 0.99;
    double value = 0;
    for (StencilMatrix::InnerIterator it(even, static_cast<int>(v)); it; ++it)
      value += it.value() * slope.dot(mesh.positions[it.col()].cast<double>());
    if (inside) {
      EXPECT_NEAR(value, 0, 1e-6);
    }
  }
}

TEST(Sampling, LaplacianDoesNotDependOnTheScale) {
  const auto mesh = test::torus(12, 8);
  auto positions = doubles(mesh.positions);
  const StencilMatrix small = normalised_laplacian(mesh.triangles, positions);
  for (auto& p : positions) p *= 100;
  const StencilMatrix large = normalised_laplacian(mesh.triangles, positions);
  EXPECT_LT((small - large).norm(), 1e-10);
}

TEST(Sampling, LaplacianOfABorderVertexRunsAlongTheBorder) {
  const auto mesh = test::disk(9, 3);
  const StencilMatrix laplacian = normalised_laplacian(mesh.triangles, doubles(mesh.positions));
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    if (mesh.positions[v].norm() < 0.99f) continue;
    int entries = 0;
    for (StencilMatrix::InnerIterator it(laplacian, static_cast<int>(v)); it; ++it, ++entries)
      EXPECT_GT(mesh.positions[it.col()].norm(), 0.99f);
    EXPECT_EQ(entries, 3);
  }
}

}  // namespace
}  // namespace phiz
