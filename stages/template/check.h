#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "formats/control_mesh.h"

namespace phiz {

/// One promise of a generic head.
struct HeadCheck {
  std::string what, value, bar;
  bool ok = false;
  std::string picture;  ///< which of list_check_pictures() shows it
};

/// Every promise that phiz makes of a generic head, measured: topology, size, valences, angles, edge loops,
/// symmetry, annotations, (u,v), the limit surface at level 4, vertex order. What builds on a promise that is
/// broken is left out (no (u,v) map of what is no disk). A head without any of the usual 68 landmarks is
/// somebody else's, an animal's or a creature's: what only a human face has is then counted and printed, with
/// no bar. Deterministic, also over threads. Half a second.
std::vector<HeadCheck> check_generic_head(const ControlMesh& head);

/// Names of the pictures, in the order in which the checks come.
std::vector<std::string> list_check_pictures();

/// What the checks measured place by place, for pictures. Arrays are empty where they make no sense.
struct HeadMeasures {
  std::vector<int> valences;                      ///< per vertex; 0 on the border
  std::vector<double> min_angles_deg;             ///< per triangle
  std::vector<Eigen::Vector2d> stretches;         ///< per triangle: mm per unit of (u,v), larger first
  std::vector<double> asymmetry_mm;               ///< per vertex: from the mirror image of its partner
  std::map<std::string, std::vector<int>> rings;  ///< per region and triangle: 0 inside, k in the k-th ring
                                                  ///< of triangles around, -1 elsewhere
  double face_mm = 0;                             ///< mean length of a unit of (u,v) on the face
};
HeadMeasures measure_head(const ControlMesh& head);

/// Pairs of triangles of the subdivided surface that cross; positions and triangles are those of `level`.
struct LimitSurface {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Vector3i> triangles;
  std::vector<std::pair<int, int>> crossings;
};
LimitSurface find_limit_crossings(const ControlMesh& head, int level);

}  // namespace phiz
