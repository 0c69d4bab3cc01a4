#include "stages/adapt/face_points.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "stages/geometry/error.h"
#include "stages/geometry/morton.h"

namespace phiz {
namespace {

constexpr int kWholeLevel = 2;
struct LinearMap {
  Eigen::Vector2f origin;
  Eigen::Vector3f start, along_u, along_v;

  explicit LinearMap(const Facet& facet) {
    const Eigen::Vector2d b = facet.uv[1] - facet.uv[0], c = facet.uv[2] - facet.uv[0];
    const double area = b.x() * c.y() - b.y() * c.x();
    const Eigen::Vector3d p = (facet.corners[1] - facet.corners[0]).cast<double>(),
                          q = (facet.corners[2] - facet.corners[0]).cast<double>();
    origin = facet.uv[0].cast<float>();
    start = facet.corners[0];
    along_u = ((p * c.y() - q * b.y()) / area).cast<float>();
    along_v = ((q * b.x() - p * c.x()) / area).cast<float>();
  }
  Eigen::Vector3f gap(const Eigen::Vector2f& uv, const Eigen::Vector3f& position) const {
    const Eigen::Vector2f step = uv - origin;
    return position - start - step.x() * along_u - step.y() * along_v;
  }
};

/// Squared distance to a triangle. Ericson, Real-Time Collision Detection (2005), 5.1.5.
float squared_distance(const std::array<Eigen::Vector3f, 3>& t, const Eigen::Vector3f& p) {
  const Eigen::Vector3f ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0];
  const float d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return ap.squaredNorm();
  const Eigen::Vector3f bp = p - t[1];
  const float d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return bp.squaredNorm();
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return (ap - d1 / (d1 - d3) * ab).squaredNorm();
  const Eigen::Vector3f cp = p - t[2];
  const float d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return cp.squaredNorm();
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return (ap - d2 / (d2 - d6) * ac).squaredNorm();
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return (bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (t[2] - t[1])).squaredNorm();
  const float sum = va + vb + vc;
  return (ap - vb / sum * ab - vc / sum * ac).squaredNorm();
}

/// Each finest triangle's area goes to its corners, and what falls to a vertex that was not chosen to its
/// parents.
void share_areas(const UvChart& chart, std::span<const Eigen::Vector3f> positions,
                 const std::vector<int>& index, SurfacePoints& points) {
  const int level = chart.level;
  std::vector<float> areas(positions.size(), 0.0f);
  for (const Eigen::Vector3i& t : chart.hierarchy.triangles(level)) {
    const float area =
        (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]).norm() / 6;
    for (const int corner : t) areas[corner] += area;
  }
  for (int k = level; k > kWholeLevel; --k) {
    for (int v = chart.hierarchy.vertex_count(k - 1); v < chart.hierarchy.vertex_count(k); ++v) {
      if (index[v] >= 0) continue;
      const Eigen::Vector2i parents = chart.hierarchy.parents(k, v);
      areas[parents[0]] += areas[v] / 2;
      areas[parents[1]] += areas[v] / 2;
    }
  }
  points.areas_mm2.resize(points.vertices.size());
  for (std::size_t i = 0; i < points.vertices.size(); ++i) points.areas_mm2[i] = areas[points.vertices[i]];
}

}  // namespace

SurfacePoints select_surface_points(const UvChart& chart, std::span<const Eigen::Vector3f> positions,
                                    double detail_mm) {
  CONTRACT(positions.size() == chart.uv.size());
  const int level = chart.level, whole_level = std::min(level, kWholeLevel);
  const int all = chart.hierarchy.vertex_count(level);
  std::vector<int> chosen(chart.hierarchy.vertex_count(whole_level));
  std::iota(chosen.begin(), chosen.end(), 0);
  for (int k = whole_level + 1; k <= level; ++k) {
    for (int v = chart.hierarchy.vertex_count(k - 1); v < chart.hierarchy.vertex_count(k); ++v) {
      const Eigen::Vector2i parents = chart.hierarchy.parents(k, v);
      const Eigen::Vector3f middle = 0.5f * (positions[parents[0]] + positions[parents[1]]);
      if ((positions[v] - middle).norm() > detail_mm) chosen.push_back(v);
    }
  }
  std::vector<Eigen::Vector3f> places;
  for (const int v : chosen) places.push_back(positions[v]);
  SurfacePoints points;
  std::vector<int> index(all, -1);
  for (const int i : morton_order(places)) {
    index[chosen[i]] = static_cast<int>(points.vertices.size());
    points.vertices.push_back(chosen[i]);
    points.uv.push_back(chart.uv[chosen[i]].cast<float>());
    points.positions.push_back(places[i]);
  }
  share_areas(chart, positions, index, points);
  return points;
}

Facet facet_of(const AdaptiveMesh& mesh, int a, int b, int c) {
  return {{mesh.position(a), mesh.position(b), mesh.position(c)}, {mesh.uv(a), mesh.uv(b), mesh.uv(c)}};
}

std::vector<int> locate_in_base(const BasePolyhedron& base, const SurfacePoints& points) {
  const UvDomain domain(base.uv, base.triangles);
  std::vector<int> faces;
  faces.reserve(points.uv.size());
  for (const Eigen::Vector2f& uv : points.uv) faces.push_back(domain.locate(uv.cast<double>()).triangle_idx);
  return faces;
}

FacePoints::FacePoints(const BasePolyhedron& base, const SurfacePoints& points,
                       std::span<const int> base_faces)
    : points_(points), order_(base_faces.size()), runs_(base.triangles.size()) {
  CONTRACT(base_faces.size() == points.uv.size());
  for (const int face : base_faces) ++runs_[face].end;
  int begin = 0;
  for (Run& run : runs_) {
    const int count = run.end;
    run = {begin, begin};
    begin += count;
  }
  for (std::size_t i = 0; i < base_faces.size(); ++i)
    order_[runs_[base_faces[i]].end++] = static_cast<int>(i);
}

/// `first` = (c, a, v) keeps what lies on a's side of the line from c to v.
void FacePoints::part(const AdaptiveMesh& mesh, int first, int second) {
  const auto& [c, a, v] = mesh.mesh().corners(first);
  const Eigen::Vector2f origin = mesh.uv(c).cast<float>(), line = (mesh.uv(v) - mesh.uv(c)).cast<float>();
  if (second >= static_cast<int>(runs_.size())) runs_.resize(mesh.mesh().face_slots());
  const Run whole = runs_[first];
  const auto middle = std::partition(order_.begin() + whole.begin, order_.begin() + whole.end, [&](int i) {
    const Eigen::Vector2f p = points_.uv[i] - origin;
    return line.x() * p.y() - line.y() * p.x() <= 0;
  });
  const int at = static_cast<int>(middle - order_.begin());
  runs_[first] = {whole.begin, at};
  runs_[second] = {at, whole.end};
  static_cast<void>(a);
}

void FacePoints::on_change(const AdaptiveMesh& mesh, const StellarChange& change) {
  if (change.is_split) {
    part(mesh, change.f, change.n);
    if (change.g >= 0) part(mesh, change.g, change.m);
    return;
  }
  runs_[change.f] = joined(change.f, change.n);
  if (change.g >= 0) runs_[change.g] = joined(change.g, change.m);
}

float FacePoints::measure_maximum(const Facet& facet, const Run& run) const {
  const LinearMap map(facet);
  float worst = 0;
  for (int i = run.begin; i < run.end; ++i)
    worst = std::max(worst, map.gap(points_.uv[order_[i]], points_.positions[order_[i]]).squaredNorm());
  return std::sqrt(worst);
}

ContourError FacePoints::measure_contour(const Facet& facet, const Run& run) const {
  const LinearMap map(facet);
  ContourError error;
  for (int i = run.begin; i < run.end; ++i) {
    const int point = order_[i];
    const float gap = map.gap(points_.uv[point], points_.positions[point]).norm();
    error.maximum_mm = std::max(error.maximum_mm, gap);
    error.integral_mm3 += static_cast<double>(gap) * points_.areas_mm2[point];
    error.area_mm2 += points_.areas_mm2[point];
  }
  return error;
}

float FacePoints::measure_distance(const Facet& facet, const Run& run) const {
  const LinearMap map(facet);
  float worst = 0;
  for (int i = run.begin; i < run.end; ++i) {
    const Eigen::Vector3f& p = points_.positions[order_[i]];
    if (map.gap(points_.uv[order_[i]], p).squaredNorm() > worst)
      worst = std::max(worst, squared_distance(facet.corners, p));
  }
  return std::sqrt(worst);
}

}  // namespace phiz
