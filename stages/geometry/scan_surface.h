#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "formats/point_cloud.h"
#include "stages/geometry/point_grid.h"

namespace phiz {

/// A small oriented piece of the scanned surface: the mean plane of the points about one place.
struct Surfel {
  Eigen::Vector3f position, normal;
  float confidence = 0;
  float border =
      0;  ///< 0 inside the scan, 1 on its rim: offset of the neighbours' centre over half their reach
};

/// A scan as a surface to be matched and measured against. Built once a fit from an oriented cloud in mm.
/// Queries are const and thread-safe. Memory about 80 bytes a point.
class ScanSurface {
 public:
  /// `surfel_mm` is the distance between surfels. Throws InvalidInput if the cloud has no normals.
  explicit ScanSurface(const PointCloud& cloud, float surfel_mm = 2.5f);
  ~ScanSurface();
  ScanSurface(const ScanSurface&) = delete;

  const std::vector<Surfel>& surfels() const { return surfels_; }

  struct Match {
    int surfel_idx = -1;
    float distance = 0;  ///< mm, in space
  };
  /// Of the twelve surfels nearest in space the one nearest in position and normal together:
  /// |p - q|^2 + normal_weight_mm^2 |n - m|^2 is least. -1 if all of them are farther than max_distance or
  /// have normals that differ by more than about 75 degrees (so too behind a sheet that faces away).
  Match find_match(const Eigen::Vector3f& position, const Eigen::Vector3f& normal, float normal_weight_mm,
                   float max_distance) const;

  struct Measurement {
    float offset_mm = 0;                               ///< along the query's normal, to the local surface
    float confidence = 0;                              ///< 0: nothing there
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< of the local surface
  };
  /// Where the line position + t normal meets the local surface, |t| <= reach_mm. The local surface is the
  /// mean of the weighted tangent planes (implicit moving least squares; Kolluri 2008) and of the weighted
  /// heights: their errors on a curved surface are equal and opposite. `bandwidth_mm` grows where points are
  /// few or noisy.
  Measurement measure(const Eigen::Vector3f& position, const Eigen::Vector3f& normal, float bandwidth_mm,
                      float reach_mm) const;

 private:
  struct Tree;
  std::vector<Surfel> surfels_;
  PointGrid grid_;
  std::vector<Eigen::Vector3f> normals_;  ///< in the grid's order
  std::vector<float> confidences_;
  std::unique_ptr<Tree> tree_;
};

}  // namespace phiz
