#include "stages/animate/block_solver.h"

#include <Eigen/SparseCholesky>

#include "stages/animate/lanes.h"
#include "stages/geometry/error.h"

namespace phiz {

BlockSolver::BlockSolver(const Eigen::SparseMatrix<double>& matrix) {
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::AMDOrdering<int>> factor(
      matrix);
  if (factor.info() != Eigen::Success || !(factor.vectorD().minCoeff() > 0))
    throw NumericalFailure("the skin's matrix is not positive definite");
  const int size = static_cast<int>(matrix.rows());
  order_.resize(size);
  for (int i = 0; i < size; ++i) order_[factor.permutationP().indices()[i]] = i;
  const Eigen::SparseMatrix<double> lower = factor.matrixL();
  offsets_.push_back(0);
  for (int column = 0; column < size; ++column) {
    for (Eigen::SparseMatrix<double>::InnerIterator entry(lower, column); entry; ++entry) {
      if (entry.row() <= column) continue;
      rows_.push_back(static_cast<int>(entry.row()));
      values_.push_back(static_cast<float>(entry.value()));
    }
    offsets_.push_back(static_cast<int>(rows_.size()));
    inverse_diagonal_.push_back(static_cast<float>(1 / factor.vectorD()[column]));
  }
}

void BlockSolver::solve(Point4* x, Point4* scratch) const {
  const int size = this->size();
  for (int i = 0; i < size; ++i) scratch[i] = x[order_[i]];
  for (int column = 0; column < size; ++column) {
    const Float4 value = load_at(scratch + column, 0);
    for (int e = offsets_[column]; e < offsets_[column + 1]; ++e) {
      Point4& target = scratch[rows_[e]];
      store4(load_at(&target, 0) - value * values_[e], target);
    }
  }
  for (int column = size - 1; column >= 0; --column) {
    Float4 value = load_at(scratch + column, 0) * inverse_diagonal_[column];
    for (int e = offsets_[column]; e < offsets_[column + 1]; ++e)
      value -= load_at(scratch + rows_[e], 0) * values_[e];
    store4(value, scratch[column]);
  }
  for (int i = 0; i < size; ++i) x[order_[i]] = scratch[i];
}

}  // namespace phiz
