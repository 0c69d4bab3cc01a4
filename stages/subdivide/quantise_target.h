#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "stages/geometry/surface_index.h"

namespace phiz {

/// The surface that a rounded one is to stay close to. Both have the same triangles. The spans must outlive
/// it.
class QuantiseTarget {
 public:
  QuantiseTarget(std::span<const Eigen::Vector3d> positions, std::span<const Eigen::Vector3i> triangles);

  const Eigen::Vector3d& position(int vertex_idx) const { return positions_[vertex_idx]; }
  double distance(const Eigen::Vector3d& point) const;
  const SurfaceIndex& index() const { return index_; }
  std::span<const Eigen::Vector3d> positions() const { return positions_; }

  /// The way from `origin` along unit `direction` to the triangles around a vertex; of several the one
  /// nearest to where the vertex itself lies along the line, which is also the answer if there is none.
  double find_way(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, int vertex_idx) const;

  /// Greatest distance, both ways, of samples around a vertex: the vertices and centres of its triangles.
  /// From the target to the rounded surface only the triangles around those vertices are looked at.
  double local_error(std::span<const Eigen::Vector3d> rounded, int vertex_idx) const;

 private:
  std::span<const int> fan(int v) const {
    return {fan_triangles_.data() + fan_offsets_[v], fan_triangles_.data() + fan_offsets_[v + 1]};
  }
  std::span<const Eigen::Vector3d> positions_;
  std::span<const Eigen::Vector3i> triangles_;
  std::vector<int> fan_offsets_, fan_triangles_;
  SurfaceIndex index_;
};

/// How far two surfaces are apart at their vertices and the centres of their triangles, both ways.
struct HausdorffSamples {
  double most_mm = 0;
  std::vector<int> vertices;  ///< around samples that are farther than asked for, ascending
};
HausdorffSamples measure_samples(const QuantiseTarget& target, std::span<const Eigen::Vector3d> rounded,
                                 std::span<const Eigen::Vector3i> triangles, double tolerance_mm);

}  // namespace phiz
