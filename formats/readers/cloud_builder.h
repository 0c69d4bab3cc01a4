#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/scan_file.h"

namespace phiz::readers {

/// What the numbers of a colour mean.
enum class ColourRange {
  bytes,     ///< 0..255
  integers,  ///< 0..255, or 0..65535 if any is larger
  numbers,   ///< 0..1; 0..255 if any is larger than 1.5; 0..65535 if any is larger than 255.5
};

/// Collects the points of one scan. Positions come as double and are kept as float relative to an origin,
/// which is settled from the first 4096 points: zero, unless the middle (the median of each coordinate) is
/// more than 100 times farther from zero than the points spread about it; then the middle, rounded to
/// integers. So a scan near zero keeps its numbers, a scan in map coordinates keeps its precision, and one
/// wild point does not matter. Attributes are given for each point or for none; an array that is short at the
/// end is dropped.
class CloudBuilder {
 public:
  /// Throws FormatError, naming `where`, if more points than `limits` allows (or than an index can hold) are
  /// announced.
  static void check_count(std::uint64_t points, const ScanLimits& limits, const char* where = "header");

  void reserve(std::size_t points) { scan.points.positions.reserve(points); }

  void add_position(double x, double y, double z) {
    if (is_settled_) {
      scan.points.positions.emplace_back(static_cast<float>(x - scan.origin.x()),
                                         static_cast<float>(y - scan.origin.y()),
                                         static_cast<float>(z - scan.origin.z()));
    } else {
      add_early(x, y, z);
    }
  }
  /// Scaled to unit length; zero where the file has none.
  void add_normal(double x, double y, double z);
  void add_colour_bytes(std::uint8_t r, std::uint8_t g, std::uint8_t b) {
    scan.points.colours.push_back({r, g, b});
  }
  /// Scaled at the end, when the largest value is known.
  void add_colour(double r, double g, double b);
  /// Kept if all are in [0,1]; divided by the largest if some are larger; not a number and negative count as
  /// 0.
  void add_confidence(double value) { scan.points.confidences.push_back(static_cast<float>(value)); }

  /// Positions given so far.
  std::size_t size() const { return early_.size() + scan.points.positions.size(); }

  /// The scan, with everything settled. The builder is used up. Throws FormatError if it holds no point.
  ScanFile finish(std::string format, ColourRange colour_range = ColourRange::bytes);

  ScanFile scan;  ///< `triangles` are the caller's

 private:
  void add_early(double x, double y, double z);
  void settle();
  void finish_colours(ColourRange range);
  void finish_confidences();

  bool is_settled_ = false;
  std::vector<Eigen::Vector3d> early_;  ///< positions seen before the origin was settled
  std::vector<std::array<float, 3>> raw_colours_;
};

}  // namespace phiz::readers
