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
  std::vector<Eigen::Vector3f> normals;              ///< unit length (to 0.0001 after a file), outward
  std::vector<std::array<std::uint8_t, 3>> colours;  ///< sRGB
  std::vector<float> confidences;                    ///< [0,1]

  std::size_t size() const { return positions.size(); }
  bool has_normals() const { return !normals.empty(); }
  bool has_colours() const { return !colours.empty(); }
  bool has_confidences() const { return !confidences.empty(); }
};

/// OpenVDB points `points`, in 2 mm voxels. Attributes and what they keep: `P` steps of 2/65535 mm, `N` Vec3f
/// in steps of 2^-14, `Cd` Vec3f that is exactly colour/255, `confidence` steps of 1/65535. The order of
/// points is not kept: it is made canonical, so that bytes depend on the set of points alone, at any thread
/// count, and a cloud that was read is written to the same bytes again. Throws FormatError: arrays of
/// differing length, no number, beyond 1 km, confidence not in [0,1]. 300,000 points take 0.1 s.
void write_vdb(const PointCloud& cloud, std::ostream& out);

/// Reads what write_vdb wrote (refused if damaged), and the first points grid of any other OpenVDB file: `P`,
/// and `N`, `Cd` (Vec3f in [0,1]) and `confidence` (float) if present. Throws FormatError.
PointCloud read_vdb_points(std::istream& in);

}  // namespace phiz
