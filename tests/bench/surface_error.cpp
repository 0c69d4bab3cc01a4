#include "tests/bench/surface_error.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "stages/geometry/point_index.h"
#include "stages/ingest/soup.h"
#include "tests/bench/figures.h"

namespace phiz::bench {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr float kOutlierMm = 5, kSeenMm = 1, kSamePlaceMm = 0.05f;

Eigen::Matrix4d truth_from_scan(const BenchSubject& subject) {
  return subject.scan_from_truth.inverse();
}

/// The generic head's neck plane, brought to the scan by the fit's own pose and size.
bool is_above_neck(const Eigen::Vector3d& place_in_head, const FittedHead& fitted, const GenericHead& head) {
  const Plane& neck = head.mesh.annotations.clipping_planes.at("neck");
  return neck.normal.dot(place_in_head) > neck.offset_mm * fitted.head_scale;
}

double scale_of(const Eigen::Matrix4d& matrix) {
  return std::cbrt(matrix.topLeftCorner<3, 3>().determinant());
}

/// Places spread by area over the true face and ears, without hair.
std::vector<Eigen::Vector3f> sample_face(const TriangleMesh& truth, const TruthLabels& labels) {
  constexpr int kPlaces = 20'000;
  ScanFile face;
  face.points.positions = truth.positions;
  for (const Eigen::Vector3i& t : truth.triangles) {
    const bool is_bare = !labels.is_hair[t[0]] && !labels.is_hair[t[1]] && !labels.is_hair[t[2]];
    if (t.maxCoeff() <= labels.face_last && is_bare) face.triangles.push_back(t);
  }
  return sample_soup(face, kPlaces).positions;
}

/// Facet normal of the truth at a place on it.
Eigen::Vector3f normal_at(const TruthScene& scene, const Eigen::Vector3f& place) {
  const auto hit = scene.surface.find_nearest(place.cast<double>(), kFar);
  const Eigen::Vector3i& t = scene.truth.triangles[hit->triangle_idx];
  const auto& p = scene.truth.positions;
  return (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).normalized();
}

Positions to_double(const std::vector<Eigen::Vector3f>& places) {
  Positions result;
  for (const Eigen::Vector3f& p : places) result.push_back(p.cast<double>());
  return result;
}

}  // namespace

TruthScene load_truth_scene(const BenchSubject& subject) {
  TriangleMesh truth = load_truth(subject);
  SurfaceIndex surface(truth.positions, truth.triangles);
  const ScanFile scan = read_scan_file(subject.scan);
  Positions places;
  places.reserve(scan.points.size());
  for (const Eigen::Vector3f& p : scan.points.positions) places.push_back(p.cast<double>() + scan.origin);
  std::vector<bool> is_used(places.size(), scan.triangles.empty());
  for (const Eigen::Vector3i& triangle : scan.triangles) {
    for (const int corner : triangle) is_used[corner] = true;
  }
  return {std::move(truth), std::move(surface), to_float(transform(truth_from_scan(subject), places)),
          std::move(is_used)};
}

double mean_distance(const std::vector<Eigen::Vector3f>& points, const SurfaceIndex& surface) {
  double sum = 0;
  for (const SurfaceHit& hit : surface.find_nearest(points, kFar)) sum += hit.distance;
  return sum / static_cast<double>(points.size());
}

double box_diagonal(const std::vector<Eigen::Vector3f>& points) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& point : points) box.extend(point);
  return box.diagonal().norm();
}

IngestShares measure_ingest(const BenchSubject& subject, const TruthScene& scene, const FittedHead& fitted,
                            const GenericHead& head) {
  const Eigen::Matrix4d truth_from_head = truth_from_scan(subject) * fitted.scan_from_head;
  const PointIndex kept(to_float(transform(truth_from_head, fitted.cloud.positions)));
  const double pitch_mm = subject.sample_pitch_scan * scale_of(truth_from_scan(subject));
  const float reach = subject.has_triangles ? static_cast<float>(pitch_mm) : kSamePlaceMm;
  const Positions in_head = transform(truth_from_head.inverse(), scene.scan_points);
  const std::vector<SurfaceHit> truth = scene.surface.find_nearest(scene.scan_points, kFar);
  IngestShares shares;
  std::size_t good = 0, good_kept = 0, outliers_kept = 0;
  for (std::size_t i = 0; i < scene.scan_points.size(); ++i) {
    const bool is_kept = kept.find_nearest(scene.scan_points[i], reach).point_idx >= 0;
    if (truth[i].distance > kOutlierMm) {
      ++shares.outliers;
      outliers_kept += is_kept;
    } else if (scene.is_used[i] && is_above_neck(in_head[i], fitted, head)) {
      ++good;
      good_kept += is_kept;
    }
  }
  shares.kept_above_neck = static_cast<double>(good_kept) / static_cast<double>(good);
  shares.dropped_outliers =
      1 - static_cast<double>(outliers_kept) / static_cast<double>(std::max<std::size_t>(1, shares.outliers));
  return shares;
}

SkinErrors measure_skin(const BenchSubject& subject, const TruthScene& scene, const TruthLabels& labels,
                        const FittedHead& fitted, const GenericHead& head, const SurfaceIndex& finest) {
  const Eigen::Matrix4d truth_from_head = truth_from_scan(subject) * fitted.scan_from_head;
  // The corners of a scan with triangles may lie far apart: what was drawn from them is what was seen.
  const std::vector<Eigen::Vector3f> seen_points =
      subject.has_triangles ? to_float(transform(truth_from_head, fitted.cloud.positions))
                            : scene.scan_points;
  const PointIndex points(seen_points);
  const std::vector<Eigen::Vector3f> skin = sample_face(scene.truth, labels);
  const Positions in_head = transform(truth_from_head.inverse(), to_double(skin));
  SkinErrors errors;
  std::vector<PointIndex::Neighbour> near;
  for (std::size_t i = 0; i < skin.size(); ++i) {
    if (!is_above_neck(in_head[i], fitted, head)) continue;
    points.find_within(skin[i], kSeenMm, near);
    if (near.empty()) continue;
    const auto hit = finest.find_nearest(skin[i].cast<double>(), kFar);
    errors.surface.push_back(hit ? hit->distance : kFar);
    const Eigen::Vector3f normal = normal_at(scene, skin[i]);
    std::vector<double> offsets;
    for (const PointIndex::Neighbour& neighbour : near) {
      offsets.push_back(normal.dot(seen_points[neighbour.point_idx] - skin[i]));
    }
    errors.point_medians.push_back(std::abs(median(std::move(offsets))));
  }
  return errors;
}

}  // namespace phiz::bench
