#include "stages/template/limit_fit.h"

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "stages/geometry/error.h"
#include "stages/subdivide/subdivide.h"
#include "stages/template/tidy.h"

namespace phiz {
namespace {

using Sparse = Eigen::SparseMatrix<double, Eigen::RowMajor>;
using Triplet = Eigen::Triplet<double>;

/// All vertices of `level` as combinations of the control vertices.
Sparse subdivision_matrix(const SubdivisionHierarchy& hierarchy, int level) {
  const int n = hierarchy.vertex_count(0);
  Sparse total(n, n);
  total.setIdentity();
  for (int k = 1; k <= level; ++k) {
    const int old_count = hierarchy.vertex_count(k - 1), count = hierarchy.vertex_count(k);
    std::vector<Triplet> entries;
    for (int v = 0; v < old_count; ++v) entries.emplace_back(v, v, 1.0);
    const auto& rows = hierarchy.stencils(k);
    for (int v = old_count; v < count; ++v) {
      for (int i = rows.offsets[v - old_count]; i < rows.offsets[v - old_count + 1]; ++i) {
        entries.emplace_back(v, rows.vertices[i], rows.weights[i]);
      }
    }
    Sparse step(count, old_count);
    step.setFromTriplets(entries.begin(), entries.end());
    total = (step * total).pruned();
  }
  return total;
}

/// Uniform Laplacian; zero rows where a vertex has no neighbour.
Sparse laplacian(const std::vector<Eigen::Vector3i>& triangles, int vertex_count) {
  std::vector<Triplet> entries;
  for (const auto& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      for (const int other : {t[(k + 1) % 3], t[(k + 2) % 3]}) {
        entries.emplace_back(t[k], other, -1.0);
        entries.emplace_back(t[k], t[k], 1.0);
      }
    }
  }
  Sparse matrix(vertex_count, vertex_count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  for (int v = 0; v < vertex_count; ++v) {
    const double degree = matrix.coeff(v, v);
    if (degree > 0) matrix.row(v) /= degree;
  }
  return matrix;
}

/// Where a vertex of the subdivided surface should be: a place on the mapped surface and its normal.
struct Target {
  Eigen::Vector3d position, normal;
};

Target find_target(const Eigen::Vector3d& p, const Eigen::Vector2d& uv, const SurfaceLookup& surface) {
  const bool left = uv[0] > 0.5;
  const Eigen::Vector2d start(left ? 1 - uv[0] : uv[0], uv[1]);
  const Eigen::Vector3d image(left ? -p[0] : p[0], p[1], p[2]);
  const auto place = surface.find(surface.descend_to(image, start));
  Target target{surface.position(place), surface.normal(place)};
  if (left) target.position[0] *= -1, target.normal[0] *= -1;
  return target;
}

class LimitFit {
 public:
  LimitFit(ControlMesh& mesh, const SurfaceLookup& surface, const LimitFitOptions& options)
      : mesh_(mesh), surface_(surface), options_(options), start_(mesh.positions) {
    const int n = static_cast<int>(mesh.positions.size());
    const SubdivisionHierarchy hierarchy(mesh.triangles, n, options.level);
    matrix_ = subdivision_matrix(hierarchy, options.level);
    uv_ = evaluate_uv(hierarchy, mesh.uv, options.level);
    const Sparse smooth = laplacian(mesh.triangles, n);
    keep_ = options.smooth_weight * Sparse(smooth.transpose() * smooth);
    for (int v = 0; v < n; ++v) keep_.coeffRef(v, v) += options.stay_weight;
    // What hangs mainly on constrained vertices is not asked for.
    std::vector<bool> constrained(n, false);
    for (const int v : mesh.annotations.constrained_vertices) constrained[v] = true;
    normals_.assign(matrix_.rows(), Eigen::Vector3d::UnitZ());
    asked_.assign(matrix_.rows(), true);
    for (int row = 0; row < matrix_.rows(); ++row) {
      double share = 0;
      for (Sparse::InnerIterator it(matrix_, row); it; ++it)
        share += constrained[it.col()] ? std::abs(it.value()) : 0;
      asked_[row] = share < 0.3;
    }
  }

  /// One round of targets and least squares; the root mean square distance before it.
  double round() {
    const Coordinates positions = to_rows(mesh_.positions);
    const Coordinates subdivided = matrix_ * positions;
    pulls_.setZero(subdivided.rows(), 3);
    double sum = 0;
    int count = 0;
    for (int row = 0; row < matrix_.rows(); ++row) {
      if (!asked_[row]) continue;
      const Target target = find_target(subdivided.row(row).transpose(), uv_[row], surface_);
      const Eigen::Vector3d off = target.position - subdivided.row(row).transpose();
      const double distance = target.normal.dot(off);
      sum += distance * distance, ++count;
      normals_[row] = target.normal;
      pulls_.row(row) = weigh(row, off).transpose();
    }
    const Coordinates right = matrix_.transpose() * pulls_ + keep_ * (to_rows(start_) - positions);
    apply(solve(right));
    return std::sqrt(sum / std::max(count, 1));
  }

 private:
  using Coordinates = Eigen::Matrix<double, Eigen::Dynamic, 3>;

  static Coordinates to_rows(const std::vector<Eigen::Vector3d>& points) {
    Coordinates rows(static_cast<Eigen::Index>(points.size()), 3);
    for (Eigen::Index k = 0; k < rows.rows(); ++k)
      rows.row(k) = points[static_cast<std::size_t>(k)].transpose();
    return rows;
  }

  /// Across the surface in full, along it by the tangential weight.
  Eigen::Vector3d weigh(int row, const Eigen::Vector3d& step) const {
    const double t = options_.tangential_weight;
    return t * step + (1 - t) * normals_[row].dot(step) * normals_[row];
  }

  /// The normal equations' matrix times a change.
  Coordinates multiply(const Coordinates& change) const {
    Coordinates rows = matrix_ * change;
    for (int row = 0; row < rows.rows(); ++row) {
      if (asked_[row])
        rows.row(row) = weigh(row, rows.row(row).transpose()).transpose();
      else
        rows.row(row).setZero();
    }
    return matrix_.transpose() * rows + keep_ * change;
  }

  /// Conjugate gradients (Hestenes and Stiefel 1952).
  Coordinates solve(const Coordinates& right) const {
    constexpr int kMaxSteps = 2000;
    constexpr double kTolerance = 1e-9;
    Coordinates change = Coordinates::Zero(right.rows(), 3), residual = right, direction = right;
    double square = residual.squaredNorm();
    const double enough = kTolerance * kTolerance * square;
    for (int step = 0; step < kMaxSteps && square > enough; ++step) {
      const Coordinates image = multiply(direction);
      const double length = square / direction.cwiseProduct(image).sum();
      change += length * direction;
      residual -= length * image;
      const double next = residual.squaredNorm();
      direction = residual + (next / square) * direction;
      square = next;
    }
    if (!std::isfinite(square)) throw NumericalFailure("the limit surface could not be fitted");
    return change;
  }

  void apply(const Coordinates& change) {
    for (std::size_t v = 0; v < mesh_.positions.size(); ++v)
      mesh_.positions[v] += change.row(static_cast<Eigen::Index>(v)).transpose();
    make_symmetric(mesh_);
    hold_back_sharp_triangles(mesh_, start_, options_.min_angle_deg);
  }

  ControlMesh& mesh_;
  const SurfaceLookup& surface_;
  const LimitFitOptions& options_;
  std::vector<Eigen::Vector3d> start_;
  Sparse matrix_, keep_;
  std::vector<Eigen::Vector2d> uv_;
  std::vector<bool> asked_;
  std::vector<Eigen::Vector3d> normals_;  ///< of the targets
  Coordinates pulls_;
};

}  // namespace

LimitFitResult fit_limit(ControlMesh& mesh, const SurfaceLookup& surface, const LimitFitOptions& options) {
  LimitFitResult result;
  LimitFit fit(mesh, surface, options);
  for (int k = 0; k < options.rounds; ++k) {
    const double distance = fit.round();
    if (k == 0) result.before_mm = distance;
    result.after_mm = distance;
  }
  return result;
}

}  // namespace phiz
