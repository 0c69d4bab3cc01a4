#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "stages/subdivide/subdivide.h"

namespace phiz {

/// Rows over control vertices: row r holds the weights that give vertex r of a level.
using StencilMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// Product of the hierarchy's stencils down to the control vertices; rows of old vertices are unit rows.
StencilMatrix compose_stencils(const SubdivisionHierarchy& hierarchy, int level);

/// Normalised Laplacian of the control mesh: row i takes the weighted mean of the neighbours of i away from
/// i. Cotangent weights of `positions`, kept positive, rows scaled to sum 1 (so that it does not depend on
/// edge length). Rows of border vertices use their border neighbours alone.
StencilMatrix normalised_laplacian(const std::vector<Eigen::Vector3i>& triangles,
                                   const std::vector<Eigen::Vector3d>& positions);

}  // namespace phiz
