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
  std::vector<Eigen::Vector2f> uv;
  std::vector<std::array<std::uint8_t, 3>> colours;

  std::size_t vertex_count() const { return positions.size(); }
  std::size_t triangle_count() const { return triangles.size(); }
};

/// Writers keep vertex and triangle order, write no time and no path: same mesh, same bytes.
void write_ply(const TriangleMesh& mesh, std::ostream& out);  ///< binary little endian, float32
void write_obj(const TriangleMesh& mesh, std::ostream& out);  ///< v, vt, vn where present; 9 significant digits

}  // namespace phiz
