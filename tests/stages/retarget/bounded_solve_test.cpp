#include "stages/retarget/bounded_solve.h"

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace phiz {
namespace {

Eigen::MatrixXd random_matrix(int rows, int columns) {
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [] { return test::random().normal(); });
}

TEST(BoundedSolve, MeetsTheConditionsOfAMinimum) {
  for (int trial = 0; trial < 100; ++trial) {
    const int n = 1 + static_cast<int>(test::random().below(12));
    const Eigen::MatrixXd half = random_matrix(n + 3, n);
    const Eigen::MatrixXd a = half.transpose() * half + 1e-3 * Eigen::MatrixXd::Identity(n, n);
    const Eigen::VectorXd b = 5 * random_matrix(n, 1);
    const Eigen::VectorXd low = -random_matrix(n, 1).cwiseAbs(), high = random_matrix(n, 1).cwiseAbs();
    const Eigen::VectorXd x = solve_bounded(a, b, low, high), slope = a * x - b;
    for (int i = 0; i < n; ++i) {
      EXPECT_GE(x[i], low[i]);
      EXPECT_LE(x[i], high[i]);
      if (x[i] > low[i] + 1e-9 && x[i] < high[i] - 1e-9) {
        EXPECT_NEAR(slope[i], 0, 1e-6);
      } else if (x[i] <= low[i] + 1e-9) {
        EXPECT_GE(slope[i], -1e-6);
      } else {
        EXPECT_LE(slope[i], 1e-6);
      }
    }
  }
}

TEST(BoundedSolve, WithoutBoundsIsTheLinearSolution) {
  const Eigen::MatrixXd half = random_matrix(8, 5), a = half.transpose() * half;
  const Eigen::VectorXd truth = random_matrix(5, 1), far = Eigen::VectorXd::Constant(5, 1e3);
  EXPECT_LT((solve_bounded(a, a * truth, -far, far) - truth).norm(), 1e-8);
}

}  // namespace
}  // namespace phiz
