#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <span>
#include <vector>

#include "stages/animate/face_layout.h"
#include "stages/animate/skin.h"

namespace phiz {

/// What of a skin is linear, and what bounds the rest. Lengths in mm, an edge's spring has stiffness 1.
struct SkinMatrices {
  std::vector<double> areas;                 ///< mm^2, a third of the triangles at a vertex
  std::vector<Eigen::Vector3d> normals;      ///< of the rest shape
  std::vector<double> skull, jaw;            ///< stiffness of the ties: options * share * area
  Eigen::SparseMatrix<double> bending_ties;  ///< bending and ties
  Eigen::SparseMatrix<double> springs;       ///< Laplacian of the edges' springs, soft phase
  std::vector<std::pair<int, int>> edges;    ///< ascending
  std::vector<double> stiffnesses;           ///< of the edges' springs
};

SkinMatrices make_skin_matrices(const FaceLayout& layout, std::span<const Eigen::Vector3d> rest,
                                const SkinOptions& options);

}  // namespace phiz
