#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <iosfwd>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace phiz {

/// A point on the surface of a control mesh: barycentric weights in one triangle.
struct SurfacePoint {
  int triangle_idx = -1;
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();  ///< sum 1, each in [0,1]
};

struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< unit
  double offset_mm = 0.0;  ///< normal . p = offset; the head is on the positive side
};

/// What is known of the generic head beyond its triangles. Names are stable identities: not empty, letters,
/// digits, `_`, `-` and `.`. Any part may be empty; whether a head is complete is its user's business.
struct Annotations {
  std::map<std::string, Eigen::AlignedBox3d> boxes;  ///< ear_left, ear_right, nose, mouth (mm)
  std::map<std::string, SurfacePoint> landmarks;     ///< 68-point names and ear points
  std::map<std::string, std::vector<int>> regions;   ///< vertices, ascending; a vertex may be in several
  std::vector<std::pair<int, int>> binding_edges;    ///< vertices held together: behind ears, between lips
  std::vector<int> constrained_vertices;             ///< inner lips: held by surroundings, not by the cloud
  std::map<std::string, Plane> clipping_planes;      ///< neck, back
  std::vector<int> mirror;  ///< vertex -> its mirror image (x -> -x), an involution; empty or one per vertex
};

/// A triangulated control mesh with one (u,v) per vertex. A topological disk; the neck loop is its boundary.
/// Positions in mm, right-handed, +y up, +z out of the face, +x to the subject's left.
struct ControlMesh {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Vector3i> triangles;  ///< counter-clockwise seen from outside
  std::vector<Eigen::Vector2d> uv;         ///< in [0,1]^2, v upwards; one per vertex
  Annotations annotations;
};

/// OBJ with `v` and `vt` (one vt per v, same index) and a JSON of annotations. Numbers have six decimals.
/// Canonical text: same mesh, same bytes, also after reading and writing again; README.md documents every
/// key. Throws FormatError: counts, indices, unknown or missing keys, values that are not numbers (with line
/// or key). Neither looks at topology. O(bytes).
ControlMesh read_control_mesh(std::istream& obj, std::istream& json);
void write_control_mesh(const ControlMesh& mesh, std::ostream& obj, std::ostream& json);

/// Position of a surface point on the given vertex positions (they may be another subject's).
/// The point's triangle must exist.
Eigen::Vector3d position_at(const SurfacePoint& point, const std::vector<Eigen::Vector3i>& triangles,
                            const std::vector<Eigen::Vector3d>& positions);

}  // namespace phiz
