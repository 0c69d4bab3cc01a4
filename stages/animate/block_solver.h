#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "stages/animate/point4.h"

namespace phiz {

/// A symmetric positive definite matrix, factored once (L D L^T, approximate minimum degree), applied to
/// three coordinates at a time in float. Deterministic.
class BlockSolver {
 public:
  /// Throws NumericalFailure where the matrix is not positive definite.
  explicit BlockSolver(const Eigen::SparseMatrix<double>& matrix);
  /// x becomes A^-1 x. `scratch` has as many points. O(entries of L).
  void solve(Point4* x, Point4* scratch) const;
  int size() const { return static_cast<int>(order_.size()); }

 private:
  std::vector<int> order_;    ///< place -> row of the matrix
  std::vector<int> offsets_;  ///< of L's columns
  std::vector<int> rows_;
  std::vector<float> values_, inverse_diagonal_;
};

}  // namespace phiz
