#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"

namespace phiz {

/// A surface over the unit square, given at the nodes of a grid: node (x, y) lies at u = x / (width - 1),
/// v = 1 - y / (height - 1), so that the borders u, v = 0 and 1 are exact and row 0 is on top. The arrays
/// besides `positions` are empty or have width x height rows.
struct GeometryImage {
  int width = 0, height = 0;               ///< 2 .. 8192
  std::string template_digest;             ///< SHA-256 of the generic head whose (u,v) this is; may be empty
  std::vector<Eigen::Vector3f> positions;  ///< mm, head frame
  std::vector<Eigen::Vector3f> normals;    ///< unit, outward
  std::vector<Eigen::Vector3f> colours;    ///< linear light, sRGB primaries, [0,1]
  std::vector<float> confidences;          ///< of the position: 1 measured, 0.5 bridged, 0 invented
  std::vector<float> mask;                 ///< of the colour: 1 seen in the scan, 0 filled in

  std::size_t node_count() const { return static_cast<std::size_t>(width) * height; }
  Eigen::Vector2d uv(int x, int y) const {
    return {x / (width - 1.0), 1 - y / (height - 1.0)};  // 0 and 1 come out exactly
  }
};

/// Throws FormatError: sizes that do not belong together, numbers that are not finite or out of range.
void check_geometry_image(const GeometryImage& image);

/// One EXR: layers P (FLOAT), N and Cd (HALF), conf.V and mask.V, and in the header schema, unit, axes,
/// (u,v) origin and template digest (README.md). Same image, same bytes. The file alone rebuilds the surface.
/// Throws FormatError; reading also for an EXR of another schema or with layers that are none of these.
void write_geometry_image(const GeometryImage& image, std::ostream& exr);
GeometryImage read_geometry_image(std::istream& exr);

/// The surface of an image as triangles: one vertex a node in row order, each cell cut along its shorter
/// diagonal, counter-clockwise seen from outside; normals (FLOAT), (u,v) and sRGB colours where the image has
/// them. O(nodes).
TriangleMesh make_grid_mesh(const GeometryImage& image);

/// The sRGB transfer function (IEC 61966-2-1), a byte to [0,1] linear and back (rounded, clamped).
float linear_from_srgb(std::uint8_t value);
std::uint8_t srgb_from_linear(float value);

}  // namespace phiz
