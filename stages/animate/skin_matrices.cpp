#include "stages/animate/skin_matrices.h"

#include <algorithm>
#include <cmath>

#include "stages/geometry/angle.h"
#include "stages/geometry/normals.h"

namespace phiz {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;
using Sparse = Eigen::SparseMatrix<double>;

constexpr double kMostBending = 30;  ///< of a vertex, in springs: fine places would become stiff
constexpr double kLoose = 0.03;      ///< of a spring's stiffness and of bending in loose regions

Sparse assemble(const Triplets& triplets, int size) {
  Sparse matrix(size, size);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

/// u -> mean of the neighbours' u - u with mean-value weights: 0 for what is linear in the tangent plane.
Sparse make_laplacian(std::span<const Eigen::Vector3i> triangles, std::span<const Eigen::Vector3d> rest) {
  const int size = static_cast<int>(rest.size());
  Triplets raw;
  std::vector<double> sums(rest.size(), 0.0);
  for (const Eigen::Vector3i& t : triangles) {
    for (int i = 0; i < 3; ++i) {
      const int a = t[i], b = t[(i + 1) % 3], c = t[(i + 2) % 3];
      const Eigen::Vector3d ab = rest[b] - rest[a], ac = rest[c] - rest[a];
      const double half_tangent = std::tan(0.5 * std::min(angle_of(ab.cross(ac).norm(), ab.dot(ac)), 2.8));
      for (const auto& [to, way] : {std::pair(b, ab), std::pair(c, ac)}) {
        const double weight = half_tangent / std::max(way.norm(), 1e-3);
        raw.emplace_back(a, to, weight);
        sums[a] += weight;
      }
    }
  }
  Triplets scaled;
  for (const auto& entry : raw)
    scaled.emplace_back(entry.row(), entry.col(), entry.value() / sums[entry.row()]);
  for (int v = 0; v < size; ++v)
    if (sums[v] > 0) scaled.emplace_back(v, v, -1.0);
  return assemble(scaled, size);
}

Eigen::VectorXd bending_weights(const SkinMatrices& matrices, std::span<const Eigen::Vector3d> rest,
                                double bend_mm2) {
  std::vector<double> lengths(rest.size(), 0.0);
  std::vector<int> counts(rest.size(), 0);
  for (const auto& [a, b] : matrices.edges) {
    const double length = (rest[a] - rest[b]).norm();
    lengths[a] += length, lengths[b] += length;
    ++counts[a], ++counts[b];
  }
  Eigen::VectorXd weights(static_cast<Eigen::Index>(rest.size()));
  for (std::size_t v = 0; v < rest.size(); ++v) {
    const double mean = std::max(lengths[v] / std::max(counts[v], 1), 1e-3);
    // The Laplace-Beltrami operator is about 4 / length^2 times the mean's difference.
    weights[static_cast<Eigen::Index>(v)] =
        std::min(bend_mm2 * 16 * matrices.areas[v] / std::pow(mean, 4), kMostBending);
  }
  return weights;
}

}  // namespace

SkinMatrices make_skin_matrices(const FaceLayout& layout, std::span<const Eigen::Vector3d> rest,
                                const SkinOptions& options) {
  const int size = static_cast<int>(rest.size());
  SkinMatrices result;
  result.normals = compute_vertex_normals(rest, layout.triangles());
  result.areas.assign(rest.size(), 0.0);
  for (const Eigen::Vector3i& t : layout.triangles()) {
    const double third = (rest[t[1]] - rest[t[0]]).cross(rest[t[2]] - rest[t[0]]).norm() / 6;
    for (int i = 0; i < 3; ++i) {
      result.areas[t[i]] += third;
      result.edges.emplace_back(std::min(t[i], t[(i + 1) % 3]), std::max(t[i], t[(i + 1) % 3]));
    }
  }
  std::sort(result.edges.begin(), result.edges.end());
  result.edges.erase(std::unique(result.edges.begin(), result.edges.end()), result.edges.end());
  Triplets springs, ties;
  for (const auto& [a, b] : result.edges) {
    const double k = layout.loose()[a] && layout.loose()[b] ? kLoose : 1;
    result.stiffnesses.push_back(k);
    springs.emplace_back(a, a, k), springs.emplace_back(b, b, k);
    springs.emplace_back(a, b, -k), springs.emplace_back(b, a, -k);
  }
  for (int v = 0; v < size; ++v) {
    const double firm = options.is_tied ? result.areas[v] / (options.tie_mm * options.tie_mm) : 0;
    result.skull.push_back(firm * (layout.skull_ties()[v] + (options.is_tied ? options.least_tie : 0)));
    result.jaw.push_back(firm * layout.jaw_ties()[v]);
    ties.emplace_back(v, v, result.skull[v] + result.jaw[v]);
  }
  result.springs = assemble(springs, size);
  const Sparse laplacian = make_laplacian(layout.triangles(), rest);
  Eigen::VectorXd weights = bending_weights(result, rest, options.bend_mm2);
  result.bending_ties =
      Sparse(laplacian.transpose() * weights.asDiagonal() * laplacian) + assemble(ties, size);
  return result;
}

}  // namespace phiz
