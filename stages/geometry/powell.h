#pragma once

#include <Eigen/Core>
#include <functional>

namespace phiz {

struct PowellOptions {
  Eigen::VectorXd initial_steps;      ///< one per parameter, > 0: the scale of the first line searches
  double relative_tolerance = 1e-4;   ///< stops when a round of all directions improves the value by less than this share
  int max_evaluations = 5000;
};

struct PowellResult {
  Eigen::VectorXd parameters;
  double value = 0;
  int evaluations = 0;
  bool converged = false;  ///< false: stopped by max_evaluations
};

/// Minimises without derivatives by successive line searches along a set of directions that is updated as it goes
/// (Powell 1964, in the form of Brent 1973, ch. 7). No randomness. Robust on staircases: line searches never
/// step below initial_steps * 2^-10. The function is called from one thread.
PowellResult minimise_powell(const std::function<double(const Eigen::VectorXd&)>& function,
                             const Eigen::VectorXd& start, const PowellOptions& options);

}  // namespace phiz
