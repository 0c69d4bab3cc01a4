#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <memory>
#include <vector>

#include "stages/fit/sampling.h"

namespace phiz {

/// One linearised distance at a surface sample p:
/// weight * (normal . (p - target))^2 + point_weight * |p - slide_target|^2.
struct SampleTerm {
  Eigen::Vector3d target = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
  Eigen::Vector3d slide_target = Eigen::Vector3d::Zero();
  double weight = 0, point_weight = 0;
};

/// weight * |x_a - x_b - difference|^2.
struct PairTerm {
  int a = 0, b = 0;
  Eigen::Vector3d difference = Eigen::Vector3d::Zero();
  double weight = 0;
};

/// weight * (normal . x_v - offset)^2.
struct PlaneTerm {
  int vertex_idx = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double offset = 0, weight = 0;
};

/// The quadratic of one step of the global fit over control positions x (V x 3):
///   sum of sample terms at S x  +  sum_i smooth_i |(L x)_i - delta_i|^2  +  pair terms  +  plane terms.
/// Minimised by conjugate gradients, preconditioned with the Cholesky factor of its isotropic part.
/// Matrix-free in the samples: O(non-zeros of S) an iteration. One thread, fixed order: deterministic.
class DeformationSystem {
 public:
  using Positions = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

  DeformationSystem(const StencilMatrix& samples, const StencilMatrix& laplacian);

  std::vector<SampleTerm> sample_terms;
  std::vector<PairTerm> pair_terms;
  std::vector<PlaneTerm> plane_terms;
  Eigen::VectorXd smooth_weights;  ///< one a control vertex
  Positions delta;                 ///< wanted Laplacians

  double energy(const Positions& x) const;
  /// Improves x until the residual has fallen by `reduction`, or `max_iterations`. Returns the iterations
  /// made.
  int solve(Positions& x, double reduction, int max_iterations) const;

 private:
  Positions gradient(const Positions& x,
                     bool homogeneous) const;  ///< half of it; homogeneous: without targets
  const StencilMatrix& samples_;
  const StencilMatrix& laplacian_;
  StencilMatrix samples_transposed_, laplacian_transposed_;
};

}  // namespace phiz
