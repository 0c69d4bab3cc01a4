#pragma once

#include <Eigen/Core>
#include <functional>

namespace phiz {

struct PowellOptions {
  Eigen::VectorXd initial_steps;  ///< one per parameter, > 0: the scale of the first line searches
  double relative_tolerance =
      1e-4;  ///< stops when a round of all directions improves the value by less than this share
  int max_evaluations = 5000;
};

struct PowellResult {
  Eigen::VectorXd parameters;
  double value = 0;
  int evaluations = 0;
  bool converged = false;  ///< false: stopped by max_evaluations
};

/// Minimises without derivatives by successive line searches along a set of directions that is updated as it
/// goes (Powell 1964; directions kept independent as in Press et al., Numerical Recipes, 10.7; parabolic line
/// searches as in Brent 1973, ch. 5). Where no direction gains any more it looks once again along the axes
/// with the initial steps. No randomness; a value that is no number counts as infinite. Robust on staircases:
/// line searches never look closer than initial_steps * 2^-10 and do not refine plateaus. The function is
/// called from the caller's thread. Typical cost: about 100 evaluations in 4 dimensions, 500 in 9.
PowellResult minimise_powell(const std::function<double(const Eigen::VectorXd&)>& function,
                             const Eigen::VectorXd& start, const PowellOptions& options);

}  // namespace phiz
