#include "stages/template/parameterise.h"

#include <Eigen/SVD>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "stages/geometry/error.h"
#include "stages/geometry/half_edge.h"

namespace phiz {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Triplet = Eigen::Triplet<double>;
constexpr int kU = 0, kV = 1;

/// Which coordinates of which vertices are given: the neck loop on three sides of the half square, the mirror
/// line.
struct Border {
  std::vector<Eigen::Vector2d> uv;
  std::array<std::vector<bool>, 2> fixed;
};

/// The neck part of the border, from throat (lower, in front) to nape.
std::vector<int> find_neck_chain(const HalfHead& head, const HalfEdgeMesh& mesh) {
  const auto loop = mesh.border_loops().at(0);
  const std::size_t n = loop.size();
  std::vector<int> chain;
  for (std::size_t k = 0; k < n && chain.empty(); ++k) {
    if (head.positions[loop[k]][0] != 0 || head.positions[loop[(k + 1) % n]][0] == 0) continue;
    chain.push_back(loop[k]);
    for (std::size_t j = k + 1;; ++j) {
      chain.push_back(loop[j % n]);
      if (head.positions[loop[j % n]][0] == 0) break;
    }
  }
  if (chain.size() < 5) throw InvalidInput("the neck loop of the reference is too coarse");
  if (head.positions[chain.front()][2] < head.positions[chain.back()][2])
    std::reverse(chain.begin(), chain.end());
  return chain;
}

Border place_border(const HalfHead& head, const HalfEdgeMesh& mesh, const MapOptions& options) {
  const auto chain = find_neck_chain(head, mesh);
  std::vector<double> length(chain.size(), 0);
  for (std::size_t k = 1; k < chain.size(); ++k) {
    length[k] = length[k - 1] + (head.positions[chain[k]] - head.positions[chain[k - 1]]).norm();
  }
  const auto nearest = [&](double share) {
    const auto at = std::min_element(length.begin(), length.end(), [&](double a, double b) {
      return std::abs(a - share * length.back()) < std::abs(b - share * length.back());
    });
    return static_cast<std::size_t>(at - length.begin());
  };
  const std::array<std::size_t, 4> corner = {0, nearest(options.lower_corner), nearest(options.upper_corner),
                                             chain.size() - 1};
  if (!(corner[0] < corner[1] && corner[1] < corner[2] && corner[2] < corner[3])) {
    throw InvalidInput("the neck loop of the reference is too coarse");
  }
  const std::array<Eigen::Vector2d, 4> place = {Eigen::Vector2d(0.5, 0), {0, 0}, {0, 1}, {0.5, 1}};

  Border border;
  border.uv.assign(head.positions.size(), {0.5, 0});
  for (auto& fixed : border.fixed) fixed.assign(head.positions.size(), false);
  for (std::size_t v = 0; v < head.positions.size(); ++v) {
    border.fixed[kU][v] = mesh.is_border_vertex(static_cast<int>(v)) && head.positions[v][0] == 0;
  }
  for (int side = 0; side < 3; ++side) {
    for (std::size_t k = corner[side]; k <= corner[side + 1]; ++k) {
      const double share =
          (length[k] - length[corner[side]]) / (length[corner[side + 1]] - length[corner[side]]);
      border.uv[chain[k]] = (1 - share) * place[side] + share * place[side + 1];
      border.fixed[kU][chain[k]] = border.fixed[kV][chain[k]] = true;
    }
  }
  return border;
}

/// Solves for the convex combination map with mean value weights.
std::vector<Eigen::Vector2d> map_by_mean_values(const HalfHead& head, const Border& border) {
  const int n = static_cast<int>(head.positions.size());
  std::vector<Triplet> weights;
  for (const auto& t : head.triangles) {
    for (int k = 0; k < 3; ++k) {
      const int i = t[k], j = t[(k + 1) % 3], l = t[(k + 2) % 3];
      const Eigen::Vector3d a = head.positions[j] - head.positions[i],
                            b = head.positions[l] - head.positions[i];
      const double la = a.norm(), lb = b.norm();
      const double cosine = std::clamp(a.dot(b) / (la * lb), -1.0, 1.0);
      const double half_tangent = std::sqrt((1 - cosine) / (1 + cosine + 1e-12));
      weights.emplace_back(i, j, half_tangent / la);
      weights.emplace_back(i, l, half_tangent / lb);
    }
  }
  std::vector<Eigen::Vector2d> uv = border.uv;
  for (const int axis : {kU, kV}) {
    const auto& fixed = border.fixed[axis];
    std::vector<Triplet> entries;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
    for (int v = 0; v < n; ++v) {
      if (fixed[v]) entries.emplace_back(v, v, 1.0), right[v] = border.uv[v][axis];
    }
    for (const auto& w : weights) {
      if (fixed[w.row()]) continue;
      entries.emplace_back(w.row(), w.row(), w.value());
      entries.emplace_back(w.row(), w.col(), -w.value());
    }
    Sparse matrix(n, n);
    matrix.setFromTriplets(entries.begin(), entries.end());
    Eigen::SparseLU<Sparse> solver(matrix);
    if (solver.info() != Eigen::Success) throw NumericalFailure("the mean value map has no solution");
    const Eigen::VectorXd x = solver.solve(right);
    for (int v = 0; v < n; ++v) uv[v][axis] = fixed[v] ? border.uv[v][axis] : x[v];
  }
  return uv;
}

/// The symmetric Dirichlet energy of the map, with a size sought for each triangle.
class Relaxation {
 public:
  Relaxation(const MappedSurface& surface, std::span<const double> sizes) : triangles_(surface.triangles) {
    for (const int axis : {kU, kV}) {
      unknown_[axis].assign(surface.uv.size(), -1);
      for (std::size_t v = 0; v < surface.uv.size(); ++v) {
        if (!is_fixed(surface.uv[v], axis)) unknown_[axis][v] = unknown_count_++;
      }
    }
    double total = 0;
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const auto& t = triangles_[i];
      const Eigen::Vector3d e1 = surface.positions[t[1]] - surface.positions[t[0]];
      const Eigen::Vector3d e2 = surface.positions[t[2]] - surface.positions[t[0]];
      const double l = e1.norm(), area2 = e1.cross(e2).norm(), x = e1.dot(e2) / l, y = area2 / l;
      Eigen::Matrix<double, 2, 3> gradient;
      gradient << -y / area2, y / area2, 0, (x - l) / area2, -x / area2, l / area2;
      gradients_.push_back(gradient);
      weights_.push_back(area2 / 2 * sizes[i] * sizes[i]);
      total += weights_.back();
    }
    const double factor = std::sqrt(0.5 / total);
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      gradients_[t] /= sizes[t] * factor;
      weights_[t] *= 2 * factor * factor;
    }
  }

  /// Infinite where a triangle is turned over.
  double energy(const std::vector<Eigen::Vector2d>& uv) const {
    double sum = 0;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      const Eigen::Matrix2d j = jacobian(uv, t);
      const double det = j.determinant();
      if (!(det > 0)) return std::numeric_limits<double>::infinity();
      sum += weights_[t] * j.squaredNorm() * (1 + 1 / (det * det));
    }
    return sum;
  }

  /// One SLIM step with a line search; the new energy.
  double step(std::vector<Eigen::Vector2d>& uv, double old_energy) {
    const Eigen::VectorXd x = solve_proxy(uv);
    std::vector<Eigen::Vector2d> trial(uv.size());
    for (double length = 1; length > 1e-7; length *= 0.6) {
      for (std::size_t v = 0; v < uv.size(); ++v) {
        for (const int axis : {kU, kV}) {
          const int i = unknown_[axis][v];
          trial[v][axis] = uv[v][axis] + (i < 0 ? 0.0 : length * x[i]);
        }
      }
      const double e = energy(trial);
      if (e < old_energy) {
        uv = trial;
        return e;
      }
    }
    return old_energy;
  }

 private:
  /// Border vertices keep what puts them on their side of the half square; its corners keep both.
  static bool is_fixed(const Eigen::Vector2d& uv, int axis) {
    const bool at_u_end = uv[kU] == 0 || uv[kU] == 0.5, at_v_end = uv[kV] == 0 || uv[kV] == 1;
    return axis == kU ? at_u_end : at_v_end;
  }

  Eigen::Matrix2d jacobian(const std::vector<Eigen::Vector2d>& uv, std::size_t t) const {
    Eigen::Matrix<double, 2, 3> corners;
    for (int k = 0; k < 3; ++k) corners.col(k) = uv[triangles_[t][k]];
    return corners * gradients_[t].transpose();
  }

  Eigen::VectorXd solve_proxy(const std::vector<Eigen::Vector2d>& uv) {
    std::vector<Triplet> entries;
    entries.reserve(triangles_.size() * 36 + unknown_count_);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(unknown_count_);
    for (int i = 0; i < unknown_count_; ++i) entries.emplace_back(i, i, 1e-9);
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      const Eigen::Matrix2d j = jacobian(uv, t);
      const Eigen::JacobiSVD<Eigen::Matrix2d> svd(j, Eigen::ComputeFullU | Eigen::ComputeFullV);
      const Eigen::Matrix2d rotation = svd.matrixU() * svd.matrixV().transpose();
      Eigen::Vector2d w2;
      for (int k = 0; k < 2; ++k) {
        const double s = std::max(svd.singularValues()[k], 1e-8);
        w2[k] = std::abs(s - 1) < 1e-4 ? 4.0 : (s - 1 / (s * s * s)) / (s - 1);
      }
      const Eigen::Matrix2d metric =
          weights_[t] * (svd.matrixU() * w2.asDiagonal() * svd.matrixU().transpose());
      const Eigen::Matrix<double, 2, 3> pull = metric * (rotation - j) * gradients_[t];
      const Eigen::Matrix3d inner = gradients_[t].transpose() * gradients_[t];
      for (int a = 0; a < 3; ++a) {
        for (const int p : {kU, kV}) {
          const int row = unknown_[p][triangles_[t][a]];
          if (row < 0) continue;
          right[row] += pull(p, a);
          for (int b = 0; b < 3; ++b) {
            for (const int q : {kU, kV}) {
              const int col = unknown_[q][triangles_[t][b]];
              if (col >= 0) entries.emplace_back(row, col, metric(p, q) * inner(a, b));
            }
          }
        }
      }
    }
    Sparse matrix(unknown_count_, unknown_count_);
    matrix.setFromTriplets(entries.begin(), entries.end());
    if (!analysed_) solver_.analyzePattern(matrix), analysed_ = true;
    solver_.factorize(matrix);
    if (solver_.info() != Eigen::Success) throw NumericalFailure("the (u,v) map could not be relaxed");
    return solver_.solve(right);
  }

  const std::vector<Eigen::Vector3i>& triangles_;
  std::array<std::vector<int>, 2> unknown_;
  int unknown_count_ = 0;
  std::vector<Eigen::Matrix<double, 2, 3>> gradients_;
  std::vector<double> weights_;
  Eigen::SimplicialLDLT<Sparse> solver_;
  bool analysed_ = false;
};

/// Each scale takes over from those before it, the more the nearer its centre.
double sought_size(const Eigen::Vector3d& p, std::span<const Layout::Scale> scales) {
  double log_size = 0;
  for (const auto& s : scales) {
    const double t =
        std::clamp((s.outer_mm - (p - s.centre_mm).norm()) / (s.outer_mm - s.inner_mm), 0.0, 1.0);
    log_size += t * t * (3 - 2 * t) * (std::log(s.scale) - log_size);
  }
  return std::exp(log_size);
}

}  // namespace

MappedSurface map_half_head(const HalfHead& head, std::span<const Layout::Scale> scales,
                            const MapOptions& options) {
  const HalfEdgeMesh mesh(head.triangles, static_cast<int>(head.positions.size()));
  const Border border = place_border(head, mesh, options);
  MappedSurface surface{head.positions, head.triangles, map_by_mean_values(head, border)};
  std::vector<double> sizes;
  for (const auto& t : head.triangles) {
    const Eigen::Vector3d centre = (head.positions[t[0]] + head.positions[t[1]] + head.positions[t[2]]) / 3.0;
    sizes.push_back(sought_size(centre, scales));
  }
  relax_map(surface, sizes, options);
  return surface;
}

void relax_map(MappedSurface& surface, std::span<const double> sizes, const MapOptions& options) {
  CONTRACT(sizes.size() == surface.triangles.size());
  Relaxation relaxation(surface, sizes);
  double energy = relaxation.energy(surface.uv);
  if (!std::isfinite(energy)) throw NumericalFailure("the (u,v) map folds before it is relaxed");
  for (int k = 0; k < options.max_iterations; ++k) {
    const double next = relaxation.step(surface.uv, energy);
    const bool settled = energy - next <= options.relative_tolerance * energy;
    energy = next;
    if (settled) break;
  }
}

}  // namespace phiz
