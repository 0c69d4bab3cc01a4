#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <algorithm>
#include <vector>

namespace phiz {

/// Lower half of a symmetric matrix of 3 x 3 blocks with a fixed pattern.
class BlockMatrix {
 public:
  void set_pattern(std::vector<std::vector<int>> columns) {
    offsets_.assign(1, 0);
    for (std::vector<int>& row : columns) {
      std::sort(row.begin(), row.end());
      row.erase(std::unique(row.begin(), row.end()), row.end());
      columns_.insert(columns_.end(), row.begin(), row.end());
      offsets_.push_back(static_cast<int>(columns_.size()));
    }
  }
  void clear() { blocks_.assign(columns_.size(), Eigen::Matrix3d::Zero()); }
  int rows() const { return static_cast<int>(offsets_.size()) - 1; }
  /// `block` must be symmetric; it is added at (a, b) and (b, a).
  void add(int a, int b, const Eigen::Matrix3d& block) {
    const int row = std::max(a, b), column = std::min(a, b);
    const auto begin = columns_.begin() + offsets_[row], end = columns_.begin() + offsets_[row + 1];
    blocks_[std::lower_bound(begin, end, column) - columns_.begin()] += block;
  }
  Eigen::SparseMatrix<double> assemble() const {
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(9 * blocks_.size());
    for (int row = 0; row < rows(); ++row) {
      for (int k = offsets_[row]; k < offsets_[row + 1]; ++k) {
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j)
            if (3 * row + i >= 3 * columns_[k] + j)
              entries.emplace_back(3 * row + i, 3 * columns_[k] + j, blocks_[k](i, j));
      }
    }
    Eigen::SparseMatrix<double> matrix(3 * rows(), 3 * rows());
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
  }

 private:
  std::vector<int> offsets_, columns_;
  std::vector<Eigen::Matrix3d> blocks_;
};

}  // namespace phiz
