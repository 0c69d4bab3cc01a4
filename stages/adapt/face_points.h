#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "stages/adapt/adaptive_mesh.h"
#include "stages/unwrap/unwrap.h"

namespace phiz {

/// What is known of a surface: vertices of its own levels, so that there are many where it has much detail.
struct SurfacePoints {
  std::vector<int> vertices;  ///< of the chart's level
  std::vector<Eigen::Vector2f> uv;
  std::vector<Eigen::Vector3f> positions;  ///< mm
  std::vector<float> areas_mm2;            ///< of the surface that each stands for
  std::vector<float> importance;           ///< [0, 1] one each, or empty: all 1
  std::vector<char> may_move;              ///< 0: the same in every pose; one each, or empty: not known
};

/// All vertices of level 2, and those of finer levels that lie more than detail_mm from the middle of their
/// two parents: nothing left out is farther than (levels - 2) detail_mm from where its surroundings put it.
/// In the order of a curve through the surface.
SurfacePoints select_surface_points(const UvChart& chart, std::span<const Eigen::Vector3f> positions,
                                    double detail_mm);

/// The base face that holds each point; depends on (u,v) alone. Throws InvalidInput as UvDomain does. 0.1 us
/// a point.
std::vector<int> locate_in_base(const BasePolyhedron& base, const SurfacePoints& points);

/// One triangle of the adaptive mesh, or one that a weld would make.
struct Facet {
  std::array<Eigen::Vector3f, 3> corners;
  std::array<Eigen::Vector2d, 3> uv;
};
Facet facet_of(const AdaptiveMesh& mesh, int a, int b, int c);

/// Distances of the surface to the facet at the same (u,v), over the facet's points.
struct ContourError {
  float maximum_mm = 0;
  double integral_mm3 = 0, area_mm2 = 0;
  double average_mm() const { return area_mm2 > 0 ? integral_mm3 / area_mm2 : 0; }
};

/// Which points lie in which face: one array in which each face's points are a run. A split parts the run in
/// two, a weld joins two that lie side by side, so that nothing else has to be kept.
class FacePoints {
 public:
  struct Run {
    int begin = 0, end = 0;
  };

  /// `base_faces`: locate_in_base of the same base and points. O(points).
  FacePoints(const BasePolyhedron& base, const SurfacePoints& points, std::span<const int> base_faces);

  void on_change(const AdaptiveMesh& mesh, const StellarChange& change);
  Run run_of(int face) const { return runs_[face]; }
  Run joined(int first, int second) const { return {runs_[first].begin, runs_[second].end}; }
  std::span<const int> points_in(const Run& run) const {
    return {order_.data() + run.begin, static_cast<std::size_t>(run.end - run.begin)};
  }

  ContourError measure_contour(const Facet& facet, const Run& run) const;
  float measure_maximum(const Facet& facet, const Run& run) const;  ///< ContourError's maximum alone
  /// The largest distance of the points to the facet itself, wherever its nearest place is: never above
  /// measure_maximum.
  float measure_distance(const Facet& facet, const Run& run) const;

 private:
  void part(const AdaptiveMesh& mesh, int first, int second);

  const SurfacePoints& points_;
  std::vector<int> order_;
  std::vector<Run> runs_;  ///< by face slot
};

}  // namespace phiz
