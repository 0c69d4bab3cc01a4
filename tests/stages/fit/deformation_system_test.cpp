#include "stages/fit/deformation_system.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "stages/geometry/error.h"
#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using Positions = DeformationSystem::Positions;
using test::random;

Eigen::Vector3d random_vector() {
  return {random().normal(), random().normal(), random().normal()};
}

/// A system with every kind of term over a small mesh, samples at level 1.
struct Problem {
  explicit Problem(const TriangleMesh& mesh)
      : count(static_cast<int>(mesh.positions.size())),
        samples(compose_stencils(SubdivisionHierarchy(mesh.triangles, count, 1), 1)),
        laplacian(normalised_laplacian(mesh.triangles, doubles(mesh))),
        system(samples, laplacian),
        start(count, 3) {
    for (int v = 0; v < count; ++v) start.row(v) = mesh.positions[v].cast<double>().transpose();
    const Positions at = samples * start;
    for (Eigen::Index i = 0; i < samples.rows(); ++i) {
      SampleTerm t;
      t.target = at.row(i).transpose() + 0.1 * random_vector();
      t.normal = random_vector().normalized();
      t.slide_target = at.row(i).transpose() + 0.1 * random_vector();
      t.weight = random().uniform();
      t.point_weight = 0.1 * random().uniform();
      system.sample_terms.push_back(t);
    }
    system.smooth_weights = Eigen::VectorXd::LinSpaced(count, 0.5, 3.0);
    system.delta = laplacian * start;
    system.pair_terms = {{0, 1, random_vector(), 0.7}, {count - 1, 2, random_vector(), 0.2}};
    system.plane_terms = {{1, random_vector().normalized(), 0.3, 1.5},
                          {count - 1, random_vector().normalized(), -0.3, 0.5}};
  }
  static std::vector<Eigen::Vector3d> doubles(const TriangleMesh& mesh) {
    std::vector<Eigen::Vector3d> result;
    for (const auto& p : mesh.positions) result.push_back(p.cast<double>());
    return result;
  }

  /// The minimiser by a dense factorisation: the Hessian and gradient come from values of the energy alone.
  Positions dense_minimum() const {
    const int n = 3 * count;
    const auto value = [&](const Eigen::VectorXd& flat) {
      Positions x(count, 3);
      for (int i = 0; i < n; ++i) x(i / 3, i % 3) = flat[i];
      return system.energy(x);
    };
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(n);
    const double at_zero = value(zero);
    Eigen::VectorXd plus(n), linear(n);
    Eigen::MatrixXd hessian(n, n);
    for (int i = 0; i < n; ++i) {
      plus[i] = value(Eigen::VectorXd::Unit(n, i));
      const double minus = value(-Eigen::VectorXd::Unit(n, i));
      linear[i] = 0.5 * (plus[i] - minus);
      hessian(i, i) = plus[i] + minus - 2 * at_zero;
    }
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < i; ++j)
        hessian(i, j) = hessian(j, i) =
            value(Eigen::VectorXd::Unit(n, i) + Eigen::VectorXd::Unit(n, j)) - plus[i] - plus[j] + at_zero;
    const Eigen::VectorXd flat = hessian.ldlt().solve(-linear);
    Positions x(count, 3);
    for (int i = 0; i < n; ++i) x(i / 3, i % 3) = flat[i];
    return x;
  }

  int count;
  StencilMatrix samples, laplacian;
  DeformationSystem system;
  Positions start;
};

TEST(DeformationSystem, FindsTheMinimumOfItsEnergy) {
  for (const TriangleMesh& mesh : {test::icosphere(0), test::open_grid(3, 3), test::disk(5, 2)}) {
    const Problem problem(mesh);
    Positions x = problem.start;
    const int iterations = problem.system.solve(x, 1e-10, 300);
    EXPECT_LT(iterations, 300);
    const Positions expected = problem.dense_minimum();
    EXPECT_LT((x - expected).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_LE(problem.system.energy(x), problem.system.energy(expected) + 1e-9);
  }
}

TEST(DeformationSystem, EveryIterationLowersTheEnergy) {
  const Problem problem(test::torus(8, 6));
  double last = problem.system.energy(problem.start);
  for (int iterations = 1; iterations <= 12; ++iterations) {
    Positions x = problem.start;
    if (problem.system.solve(x, 1e-9, iterations) < iterations) break;
    const double energy = problem.system.energy(x);
    EXPECT_LT(energy, last);
    last = energy;
  }
}

TEST(DeformationSystem, StaysAtTheMinimum) {
  Problem problem(test::icosphere(1));
  problem.system.pair_terms.clear();
  problem.system.plane_terms.clear();
  const Positions at = problem.samples * problem.start;
  for (Eigen::Index i = 0; i < at.rows(); ++i)
    problem.system.sample_terms[i].target = problem.system.sample_terms[i].slide_target =
        at.row(i).transpose();
  EXPECT_NEAR(problem.system.energy(problem.start), 0, 1e-20);
  Positions x = problem.start;
  problem.system.solve(x, 1e-2, 40);
  EXPECT_LT((x - problem.start).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(DeformationSystem, WithoutDataKeepsTheShapeAndFollowsThePlane) {
  Problem problem(test::icosphere(1));
  for (auto& t : problem.system.sample_terms) t.weight = t.point_weight = 0;
  problem.system.pair_terms.clear();
  problem.system.plane_terms = {{0, Eigen::Vector3d::UnitZ(), problem.start(0, 2) + 5, 1.0}};
  Positions x = problem.start;
  problem.system.solve(x, 1e-8, 200);
  for (Eigen::Index v = 0; v < x.rows(); ++v)
    EXPECT_LT((x.row(v) - problem.start.row(v) - Eigen::RowVector3d(0, 0, 5)).norm(), 1e-3);
}

TEST(DeformationSystem, WantsATermForEachSample) {
  Problem problem(test::icosphere(0));
  problem.system.sample_terms.pop_back();
  Positions x = problem.start;
  EXPECT_THROW(problem.system.solve(x, 1e-2, 10), ContractViolation);
}

}  // namespace
}  // namespace phiz
