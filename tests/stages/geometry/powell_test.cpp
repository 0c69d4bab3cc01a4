#include "stages/geometry/powell.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "stages/geometry/error.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using Eigen::VectorXd;

PowellOptions options(int dimensions, double step = 0.5) {
  PowellOptions result;
  result.initial_steps = VectorXd::Constant(dimensions, step);
  return result;
}

double rosenbrock(const VectorXd& x) {
  double sum = 0;
  for (int i = 0; i + 1 < x.size(); ++i)
    sum += 100 * std::pow(x[i + 1] - x[i] * x[i], 2) + std::pow(1 - x[i], 2);
  return sum;
}

TEST(Powell, FindsTheBottomOfASkewBowl) {
  test::Random& random = test::random();
  for (int round = 0; round < 10; ++round) {
    constexpr int kDimensions = 6;
    Eigen::MatrixXd factor(kDimensions, kDimensions);
    VectorXd bottom(kDimensions);
    for (double& x : factor.reshaped()) x = random.normal();
    for (double& x : bottom) x = random.normal();
    const Eigen::MatrixXd bowl =
        factor * factor.transpose() + 0.3 * Eigen::MatrixXd::Identity(kDimensions, kDimensions);
    const auto value = [&](const VectorXd& x) { return 2.0 + (x - bottom).dot(bowl * (x - bottom)); };
    const PowellResult result = minimise_powell(value, VectorXd::Zero(kDimensions), options(kDimensions));
    EXPECT_TRUE(result.converged);
    EXPECT_NEAR(result.value, 2.0, 1e-3);
    EXPECT_LT((result.parameters - bottom).norm(), 0.05);
    EXPECT_EQ(result.value, value(result.parameters));
  }
}

TEST(Powell, FollowsACurvedValley) {
  const PowellResult two = minimise_powell(rosenbrock, Eigen::Vector2d(-1.2, 1), options(2));
  EXPECT_TRUE(two.converged);
  EXPECT_LT(two.value, 1e-6);
  EXPECT_LT(two.evaluations, 400);
  const PowellResult eight = minimise_powell(rosenbrock, VectorXd::Constant(8, -0.5), options(8));
  EXPECT_LT(eight.value, 1e-4);
}

TEST(Powell, WalksDownAStaircase) {
  const auto staircase = [](const VectorXd& x) {
    double sum = 0;
    for (int i = 0; i < x.size(); ++i) sum += std::floor(10 * std::abs(x[i] - 0.3 * std::sin(i)));
    return sum;
  };
  const PowellResult result = minimise_powell(staircase, VectorXd::Constant(20, 1.5), options(20));
  EXPECT_TRUE(result.converged);
  EXPECT_EQ(result.value, 0);
  EXPECT_LT(result.evaluations, 1000);
}

/// A silhouette without symmetry, turned, shifted and scaled: what alignment looks at.
bool is_inside(const VectorXd& x, double u, double v) {
  const Eigen::Vector2d p = Eigen::Rotation2Dd(-x[0]) * Eigen::Vector2d(u - x[1], v - x[2]) / x[3];
  const double angle = std::atan2(p.y(), p.x());
  return p.norm() <
         0.7 + 0.12 * std::cos(2 * angle) + 0.1 * std::cos(3 * angle + 1) + 0.05 * std::sin(5 * angle);
}

TEST(Powell, AlignsSilhouettesByCountingPixels) {
  const Eigen::Vector4d wanted(0.15, 0.2, -0.1, 0.85);
  int area = 0;
  const auto differing = [&](const VectorXd& x) {
    int count = 0;
    area = 0;
    for (int i = 0; i < 64; ++i)
      for (int j = 0; j < 64; ++j) {
        const double u = (i - 31.5) / 24, v = (j - 31.5) / 24;
        count += is_inside(x, u, v) != is_inside(wanted, u, v);
        area += is_inside(wanted, u, v);
      }
    return static_cast<double>(count);
  };
  const PowellResult result = minimise_powell(differing, Eigen::Vector4d(0, 0, 0, 1), options(4, 0.1));
  EXPECT_TRUE(result.converged);
  EXPECT_LT(result.value, 0.02 * area);
  EXPECT_LT(result.evaluations, 300);
}

TEST(Powell, APlateauCostsLittle) {
  const PowellResult flat =
      minimise_powell([](const VectorXd&) { return 3.0; }, VectorXd::Zero(9), options(9));
  EXPECT_TRUE(flat.converged);
  EXPECT_EQ(flat.parameters, VectorXd::Zero(9));
  EXPECT_LT(flat.evaluations, 60);
}

TEST(Powell, StopsAtTheLimitAndSaysSo) {
  PowellOptions few = options(8);
  few.max_evaluations = 40;
  const PowellResult result = minimise_powell(rosenbrock, VectorXd::Constant(8, -0.5), few);
  EXPECT_FALSE(result.converged);
  EXPECT_LE(result.evaluations, 45);
  EXPECT_LE(result.value, rosenbrock(VectorXd::Constant(8, -0.5)));
}

TEST(Powell, ValuesThatAreNoNumbersAreAvoided) {
  const auto value = [](const VectorXd& x) {
    return std::sqrt(x[0]) + std::pow(x[0] - 1, 2);
  };  // NaN below 0
  const PowellResult result = minimise_powell(value, VectorXd::Constant(1, 0.4), options(1));
  EXPECT_TRUE(std::isfinite(result.value));
  EXPECT_GE(result.parameters[0], 0);
  const PowellResult flat =
      minimise_powell([](const VectorXd&) { return 3.0; }, VectorXd::Zero(3), options(3));
  EXPECT_TRUE(flat.converged);
  EXPECT_EQ(flat.parameters, VectorXd::Zero(3));
}

TEST(Powell, RefusesStepsThatAreNotPositive) {
  EXPECT_THROW(minimise_powell(rosenbrock, VectorXd::Zero(2), options(3)), ContractViolation);
  EXPECT_THROW(minimise_powell(rosenbrock, VectorXd::Zero(2), options(2, 0)), ContractViolation);
}

}  // namespace
}  // namespace phiz
