#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>

namespace phiz {

/// Nearest point of one triangle (a, b, c) to a query: a + v (b - a) + w (c - a).
struct TrianglePoint {
  double v = 0, w = 0;
  double squared_distance = std::numeric_limits<double>::infinity();
};

namespace triangle_distance_detail {

inline void consider(const Eigen::Vector3d& from_a, const Eigen::Vector3d& ab, const Eigen::Vector3d& ac,
                     double v, double w, TrianglePoint& best) {
  const double squared = (from_a - (v * ab + w * ac)).squaredNorm();
  if (squared < best.squared_distance) best = {v, w, squared};
}

/// Share of the way along `edge` that is nearest to a point `from_start` away from its start.
inline double clamp_to_edge(const Eigen::Vector3d& from_start, const Eigen::Vector3d& edge) {
  const double squared_length = edge.squaredNorm(), along = from_start.dot(edge);
  if (!(along > 0)) return 0;
  return along < squared_length ? along / squared_length : 1;
}

}  // namespace triangle_distance_detail

/// The regions are told apart by signed areas on the triangle's own plane (Ericson, Real-Time Collision
/// Detection, 2005, 5.1.5, first form): unlike the expanded products, these stay accurate for slivers and for
/// far queries. A triangle without an area counts as its three edges. A vertex or an edge shared by two
/// triangles gives both the same distance, up to the rounding of edges that the two run through in opposite
/// directions.
inline TrianglePoint find_nearest_on_triangle(const Eigen::Vector3d& query, const Eigen::Vector3d& a,
                                              const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  using namespace triangle_distance_detail;
  const Eigen::Vector3d ab = b - a, ac = c - a, from_a = query - a;
  const Eigen::Vector3d normal = ab.cross(ac);
  const double area = normal.squaredNorm();
  const double along_b = normal.dot(from_a.cross(ac));
  const double along_c = normal.dot(ab.cross(from_a));
  TrianglePoint best;
  if (area > 0 && along_b >= 0 && along_c >= 0 && along_b + along_c <= area) {
    consider(from_a, ab, ac, along_b / area, along_c / area, best);
    return best;
  }
  const bool flat = !(area > 0);
  if (flat || along_c <= 0) consider(from_a, ab, ac, clamp_to_edge(from_a, ab), 0, best);
  if (flat || along_b <= 0) consider(from_a, ab, ac, 0, clamp_to_edge(from_a, ac), best);
  if (flat || along_b + along_c >= area) {
    const double t = clamp_to_edge(query - b, c - b);
    consider(from_a, ab, ac, 1 - t, t, best);
  }
  return best;
}

}  // namespace phiz
