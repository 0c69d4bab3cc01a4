#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>

#include "formats/scan_file.h"

namespace phiz::readers {

/// Unique ids of the attributes in a Draco stream; -1: take the one of that kind.
struct DracoAttributeIds {
  int position = -1, normal = -1, colour = -1;
};

/// A decoded Draco stream, mesh or point cloud.
class DracoGeometry {
 public:
  /// `file_byte` is where the stream stands in its file, for messages. Counts are checked against `limits`
  /// and the length of the stream before decoding, indices after. Throws FormatError.
  DracoGeometry(std::span<const std::byte> stream, std::size_t file_byte, const DracoAttributeIds& ids,
                const ScanLimits& limits);
  ~DracoGeometry();
  DracoGeometry(const DracoGeometry&) = delete;
  DracoGeometry& operator=(const DracoGeometry&) = delete;

  std::size_t point_count() const;
  std::size_t triangle_count() const;
  bool has_normals() const;
  bool has_colours() const;
  Eigen::Vector3d position(std::size_t point_idx) const;
  Eigen::Vector3d normal(std::size_t point_idx) const;
  Eigen::Vector3d colour(
      std::size_t point_idx) const;  ///< integers scaled to [0,1], real numbers as they are
  Eigen::Vector3i triangle(std::size_t triangle_idx) const;

 private:
  struct Decoded;
  std::unique_ptr<Decoded> decoded_;
};

/// A file may make many points from few bytes (by instances or by compression), but not more than a scan ever
/// does. Throws FormatError if `points` is more than 256 for each byte.
void check_points_per_byte(std::uint64_t points, std::size_t bytes, std::size_t file_byte);

}  // namespace phiz::readers
