#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <iosfwd>
#include <vector>

namespace phiz {

/// An unordered set of surface samples. `positions` is N x 3; each other array is empty or has N rows.
/// Frame and unit are the owner's business: mm, +y up, +z forward once ingested.
struct PointCloud {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector3f> normals;               ///< unit length, outward
  std::vector<std::array<std::uint8_t, 3>> colours;   ///< sRGB
  std::vector<float> confidences;                     ///< [0,1]

  std::size_t size() const { return positions.size(); }
  bool has_normals() const { return !normals.empty(); }
  bool has_colours() const { return !colours.empty(); }
  bool has_confidences() const { return !confidences.empty(); }
};

/// OpenVDB points: `P` (16-bit fixed in 2 mm voxels: steps of 0.00003 voxel), `N`, `Cd` as Vec3f, `confidence`.
/// Bytes depend on the content alone (grid order of points is canonical; the writer's UUID is replaced).
/// The order of points is not kept. Throws FormatError.
void write_vdb(const PointCloud& cloud, std::ostream& out);

/// Reads what write_vdb wrote, and any OpenVDB points grid with `P`. Throws FormatError.
PointCloud read_vdb_points(std::istream& in);

}  // namespace phiz
