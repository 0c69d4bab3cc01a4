#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <iosfwd>
#include <vector>

namespace phiz {

/// Truncated signed distance to the scanned surface, sampled on a sparse lattice, and how far each sample is
/// to be trusted. Plain arrays; OpenVDB is only its file. Sample i sits at origin_mm + voxel_mm *
/// coordinates[i].
struct DistanceField {
  double voxel_mm = 1.0;
  double truncation_mm = 3.0;  ///< |distance| <= truncation
  Eigen::Vector3d origin_mm = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3i> coordinates;  ///< unique, in lexicographic (x,y,z) order, within +-2^20
  std::vector<float> distances_mm;           ///< positive outside
  std::vector<float> confidences;            ///< [0,1]
};

/// OpenVDB grids `surface` (GRID_LEVEL_SET) and `confidence`; samples are the active voxels. Nothing is
/// rounded; bytes depend on content alone. Throws FormatError: arrays of differing length, coordinates out of
/// order, values out of range or no numbers. 300,000 samples take 0.05 s.
void write_vdb(const DistanceField& field, std::ostream& out);

/// Reads what write_vdb wrote (refused if damaged). Throws FormatError, also where either grid is missing.
DistanceField read_vdb_distance_field(std::istream& in);

}  // namespace phiz
