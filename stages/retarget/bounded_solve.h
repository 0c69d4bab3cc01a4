#pragma once

#include <Eigen/Core>

namespace phiz {

/// Minimises x^T A x / 2 - b^T x with low <= x <= high; A symmetric and positive definite. Active set; exact
/// but for cycling, which ends after a few passes.
Eigen::VectorXd solve_bounded(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& low,
                              const Eigen::VectorXd& high);

}  // namespace phiz
