#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/triangle_mesh.h"

namespace phiz {

/// A mesh on a lattice: what the Draco stream of a head holds exactly. Position = step * q; texture = t /
/// 65535. Draco ids: 0 POSITION, 1 TEX_COORD, so that any reader gets positions and texture coordinates as
/// floats.
struct LatticeMesh {
  std::vector<Eigen::Vector3i> positions;
  std::vector<Eigen::Vector3i> triangles;
  std::vector<Eigen::Vector2i> texture;  ///< in [0, 65535]
};

/// Sequential Draco, vertex and triangle order kept; decoded again and compared before it is returned. Throws
/// FormatError where floats cannot hold the lattice (more than 2^22 steps across, or a step too fine).
std::string encode_lattice_mesh(const LatticeMesh& mesh, double step);

/// Throws FormatError unless the stream holds just so many vertices and triangles with indices in range; the
/// counts are compared before anything is allocated.
LatticeMesh decode_lattice_mesh(std::string_view bytes, double step, std::size_t vertex_count,
                                std::size_t triangle_count);

/// Positions and triangles alone, vertex and triangle order kept: edgebreaker where the mesh has an order
/// that it returns (stages/template/canonical_order.h) when it is handed over backwards, else sequential.
/// Decoded again and compared. Throws FormatError as encode_lattice_mesh does.
std::string encode_lattice_surface(const std::vector<Eigen::Vector3i>& positions,
                                   const std::vector<Eigen::Vector3i>& triangles, double step);

/// As decode_lattice_mesh, without texture.
LatticeMesh decode_lattice_surface(std::string_view bytes, double step, std::size_t vertex_count,
                                   std::size_t triangle_count);

/// A mesh for others to look at, as small as Draco makes it: order is not kept, positions are rounded to
/// `step` (of the mesh's unit). What a decoder gets is told beside it.
struct SurfaceStream {
  std::string bytes;
  std::size_t vertex_count = 0, triangle_count = 0;
  Eigen::Vector3f low = Eigen::Vector3f::Zero(), high = Eigen::Vector3f::Zero();
};
SurfaceStream encode_surface(const TriangleMesh& mesh, double step);

/// One number after another, entropy coded: a Draco point cloud with one generic attribute (int32), no
/// prediction.
std::string encode_integers(std::span<const std::int32_t> numbers);
std::vector<std::int32_t> decode_integers(std::string_view bytes, std::size_t count);

/// Sequential Draco of any mesh: positions in 16 bits of the longest side, normals in 10, uv in 14, colours
/// exact.
std::string encode_draco(const TriangleMesh& mesh);

}  // namespace phiz
