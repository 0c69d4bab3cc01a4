#pragma once

#include "stages/template/mapped_surface.h"
#include "stages/template/triangulate.h"

namespace phiz {

/// Positions on the surface.
std::vector<Eigen::Vector3d> lift(const HalfMesh& mesh, const SurfaceLookup& surface);

struct FlipOptions {
  double valence_weight = 0.12;  ///< of squared deviations from the regular valence
  double chord_weight = 0.8;     ///< of the distance of edges from the surface, as a share of their length
  double bounds_weight = 0;      ///< of squared valences below 4 or above 8 of the whole mesh
  int max_rounds = 30;
};

/// Whether a vertex off the neck loop has a valence below 4 or above 8 in the whole mesh.
bool has_odd_valences(const HalfMesh& mesh);

/// Flips edges that belong to no curve where that improves angles on the surface, valences and closeness to
/// the surface together. One-to-one in (u,v) stays so. Deterministic. Returns the number of flips.
int flip_edges(HalfMesh& mesh, const SurfaceLookup& surface, const FlipOptions& options = {});

/// Moves the vertices that are not held along the surface towards even triangles, sweep by sweep (the sum of
/// squared inverse mean ratios of the triangles around a vertex goes down). Border and mirror line stay.
/// Vertices on the mirror line slide along it. (u,v) stays one-to-one. Deterministic.
void relax(HalfMesh& mesh, const SurfaceLookup& surface, int sweeps);

/// Smallest angle of each triangle in degrees.
std::vector<double> min_angles_deg(const std::vector<Eigen::Vector3d>& positions,
                                   const std::vector<Eigen::Vector3i>& triangles);

}  // namespace phiz
