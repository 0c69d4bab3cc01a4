#include "stages/fit/folds.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>

#include "stages/geometry/error.h"
#include "stages/geometry/half_edge.h"

namespace phiz {
namespace {

using Positions = FoldSearch::Positions;

constexpr double kLeastTurnDot = 0.1;  ///< a triangle turned by more than 84 degrees is folded

Eigen::Vector3d facet_normal(const Positions& p, const Eigen::Vector3i& t) {
  const Eigen::RowVector3d a = p.row(t[0]);
  return (p.row(t[1]) - a).cross(p.row(t[2]) - a).normalized().transpose();
}

void widen(const std::vector<Eigen::Vector3i>& triangles, std::vector<char>& free) {
  const std::vector<char> before = free;
  for (const Eigen::Vector3i& t : triangles)
    if (before[t[0]] || before[t[1]] || before[t[2]]) free[t[0]] = free[t[1]] = free[t[2]] = 1;
}

StencilMatrix square(const StencilMatrix& matrix) {
  const StencilMatrix transposed = matrix.transpose();
  return transposed * matrix;
}

/// The matrix with zeros in the rows that are not wanted.
StencilMatrix rows_of(const StencilMatrix& matrix, const std::vector<char>& wanted) {
  StencilMatrix rows = matrix;
  for (Eigen::Index row = 0; row < rows.rows(); ++row)
    if (!wanted[row])
      for (StencilMatrix::InnerIterator it(rows, row); it; ++it) it.valueRef() = 0;
  return rows;
}

/// Vertices within their width of the triangles; never those of the border, which other terms hold in place.
std::vector<char> find_surroundings(const std::vector<Eigen::Vector3i>& triangles,
                                    const std::vector<int>& widths, const std::vector<char>& border) {
  std::vector<char> free(border.size(), 0);
  for (int width = *std::max_element(widths.begin(), widths.end()); width >= 1; --width) {
    for (std::size_t t = 0; t < triangles.size(); ++t)
      if (widths[t] == width) free[triangles[t][0]] = free[triangles[t][1]] = free[triangles[t][2]] = 1;
    if (width > 1) widen(triangles, free);
  }
  for (std::size_t v = 0; v < free.size(); ++v) free[v] = free[v] && !border[v];
  return free;
}

std::vector<char> find_border(const std::vector<Eigen::Vector3i>& triangles, int vertex_count) {
  const HalfEdgeMesh mesh(triangles, vertex_count);
  std::vector<char> border(vertex_count, 0);
  for (int v = 0; v < vertex_count; ++v) border[v] = mesh.is_border_vertex(v);
  return border;
}

/// The displacement of free vertices with the least energy, all others given. `bending`: the matrix of the
/// energy.
void smooth_displacement(const StencilMatrix& bending, const Positions& rest, const std::vector<char>& free,
                         Positions& x) {
  std::vector<int> unknown(free.size(), -1), vertices;
  for (std::size_t v = 0; v < free.size(); ++v)
    if (free[v]) unknown[v] = static_cast<int>(vertices.size()), vertices.push_back(static_cast<int>(v));
  const Eigen::Index count = static_cast<Eigen::Index>(vertices.size());
  if (count == x.rows()) return;  // nothing is given to go by
  std::vector<Eigen::Triplet<double>> entries;
  Positions right = Positions::Zero(count, 3);
  for (Eigen::Index row = 0; row < count; ++row)
    for (StencilMatrix::InnerIterator it(bending, vertices[row]); it; ++it) {
      if (unknown[it.col()] >= 0) {
        entries.emplace_back(row, unknown[it.col()], it.value());
      } else {
        right.row(row) -= it.value() * (x.row(it.col()) - rest.row(it.col()));
      }
    }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
  if (solver.info() != Eigen::Success) return;
  const Positions displacement = solver.solve(right);
  for (Eigen::Index row = 0; row < count; ++row)
    x.row(vertices[row]) = rest.row(vertices[row]) + displacement.row(row);
}

}  // namespace

std::vector<int> find_folded(const FoldSearch& surface, const Positions& x) {
  CONTRACT(static_cast<int>(surface.samples.size()) <= surface.hierarchy.level_count());
  std::vector<char> folded(surface.hierarchy.triangles(0).size(), 0);
  const auto mark = [&](const Positions& at, const Positions& at_rest, int level) {
    const std::vector<Eigen::Vector3i>& triangles = surface.hierarchy.triangles(level);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const Eigen::Vector3d normal_at_rest = facet_normal(at_rest, triangles[t]);
      if (normal_at_rest.squaredNorm() < 0.5) continue;  // without an area it faces nowhere
      if (!(facet_normal(at, triangles[t]).dot(normal_at_rest) >= kLeastTurnDot))
        folded[t >> (2 * level)] = 1;
    }
  };
  mark(x, surface.rest, 0);
  for (std::size_t i = 0; i < surface.samples.size(); ++i)
    mark(surface.samples[i] * x, surface.samples[i] * surface.rest, static_cast<int>(i) + 1);
  std::vector<int> triangles;
  for (std::size_t t = 0; t < folded.size(); ++t)
    if (folded[t]) triangles.push_back(static_cast<int>(t));
  return triangles;
}

int lay_folds_flat(const FoldSearch& surface, Positions& x, int rings) {
  CONTRACT(x.rows() == surface.rest.rows());
  const std::vector<Eigen::Vector3i>& triangles = surface.hierarchy.triangles(0);
  std::vector<int> folded = find_folded(surface, x);
  if (folded.empty()) return 0;
  const StencilMatrix bending = square(surface.laplacian);
  const std::vector<char> border = find_border(triangles, static_cast<int>(x.rows()));
  Positions best = x;
  std::size_t fewest = folded.size();
  for (const bool stretch : {false, true}) {
    std::vector<int> widths(triangles.size(), 0);  // of the surroundings that each has taken so far
    for (int pass = 0; pass < 2 * rings && !folded.empty(); ++pass) {
      for (const int t : folded) widths[t] = std::min(widths[t] + 1, rings);
      const std::vector<char> free = find_surroundings(triangles, widths, border);
      smooth_displacement(stretch ? square(rows_of(surface.laplacian, free)) : bending, surface.rest, free,
                          x);
      folded = find_folded(surface, x);
      if (folded.size() < fewest) fewest = folded.size(), best = x;
    }
    // Least bending meets the surroundings smoothly but may overshoot; what stays folded then is stretched
    // across.
    x = best;
    folded = find_folded(surface, x);
  }
  return static_cast<int>(fewest);
}

}  // namespace phiz
