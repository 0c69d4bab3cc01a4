#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <iosfwd>
#include <vector>

namespace phiz {

/// Plain indexed triangles. `normals`, `uv` and `colours` are empty or have one row per vertex.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector3i> triangles;
  std::vector<Eigen::Vector3f> normals;
  std::vector<Eigen::Vector2f> uv;                   ///< v upwards, as in OBJ
  std::vector<std::array<std::uint8_t, 3>> colours;  ///< sRGB

  std::size_t vertex_count() const { return positions.size(); }
  std::size_t triangle_count() const { return triangles.size(); }
};

/// Throws FormatError where arrays differ in length, a corner is no vertex or a number is not finite. O(V +
/// F).
void check_mesh(const TriangleMesh& mesh);

/// Writers keep vertex and triangle order, write no time and no path: same mesh, same bytes.
/// They check_mesh first; write_glb and write_drc are in gltf.h.
void write_ply(const TriangleMesh& mesh, std::ostream& out);  ///< binary little endian, float32; uv as s t
void write_obj(const TriangleMesh& mesh, std::ostream& out);  ///< v [r g b], vt, vn; 9 significant digits

}  // namespace phiz
