#include <Eigen/Geometry>
#include <limits>

#include "stages/evaluate/evaluate.h"
#include "stages/evaluate/sorter.h"
#include "stages/geometry/error.h"
#include "stages/geometry/point_index.h"
#include "stages/geometry/surface_index.h"

namespace phiz {
namespace {

constexpr double kAnyDistance = std::numeric_limits<double>::infinity();

SurfaceIndex make_index(const SurfaceView& surface) {
  if (surface.triangles.empty()) throw InvalidInput("the surface to be compared with has no triangle");
  return SurfaceIndex(surface.positions, surface.triangles);
}

int nearest_corner(const SurfaceHit& hit, const SurfaceView& surface) {
  int corner = 0;
  hit.weights.maxCoeff(&corner);
  return surface.triangles[hit.triangle_idx][corner];
}

/// Indices of the truth's vertices with a point of the cloud nearby; isolated ones do not count.
std::vector<int> find_seen(const SurfaceView& truth, std::span<const Eigen::Vector3f> cloud, double seen_mm) {
  std::vector<bool> is_used(truth.positions.size(), false);
  for (const Eigen::Vector3i& triangle : truth.triangles) {
    for (int i = 0; i < 3; ++i) is_used[triangle[i]] = true;
  }
  const PointIndex index(cloud);
  std::vector<int> seen;
  for (std::size_t v = 0; v < truth.positions.size(); ++v) {
    if (!is_used[v]) continue;
    if (index.find_nearest(truth.positions[v], static_cast<float>(seen_mm)).point_idx < 0) continue;
    seen.push_back(static_cast<int>(v));
  }
  return seen;
}

/// Collects one direction's distances.
struct Direction {
  explicit Direction(const FittedLabels& fitted_labels)
      : labels(fitted_labels), by_region(fitted_labels.regions) {}

  void add(int fitted_vertex_idx, double distance_mm) {
    all.push_back(distance_mm);
    by_region.add(fitted_vertex_idx, distance_mm);
    if (!labels.confidences.empty()) {
      by_confidence[name_confidence(labels.confidences[fitted_vertex_idx])].push_back(distance_mm);
    }
  }
  StatsByName confidence_stats() const {
    StatsByName stats;
    for (const auto& [name, list] : by_confidence) stats[name] = compute_error_stats(list);
    return stats;
  }

  const FittedLabels& labels;
  std::vector<double> all;
  RegionSorter by_region;
  std::map<std::string, std::vector<double>> by_confidence;
};

}  // namespace

void check_regions(const Regions& regions, std::size_t vertex_count) {
  for (const auto& [name, flags] : regions) {
    if (flags.size() == vertex_count) continue;
    throw InvalidInput("region '" + name + "' is for " + std::to_string(flags.size()) +
                       " vertices, the surface has " + std::to_string(vertex_count));
  }
}

double compute_box_diagonal(std::span<const Eigen::Vector3f> points) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& point : points) box.extend(point.cast<double>());
  return box.isEmpty() ? 0 : box.diagonal().norm();
}

std::vector<double> compute_distances(std::span<const Eigen::Vector3f> points, const SurfaceView& surface) {
  std::vector<double> distances;
  for (const SurfaceHit& hit : make_index(surface).find_nearest(points, kAnyDistance)) {
    distances.push_back(hit.distance);
  }
  return distances;
}

SurfaceErrors compute_surface_errors(const SurfaceView& fitted, const FittedLabels& labels,
                                     const SurfaceView& truth, std::span<const Eigen::Vector3f> cloud,
                                     const SurfaceErrorOptions& options) {
  check_regions(labels.regions, fitted.positions.size());
  check_regions(options.truth_regions, truth.positions.size());
  if (!labels.confidences.empty() && labels.confidences.size() != fitted.positions.size()) {
    throw InvalidInput("confidences and fitted vertices differ in number");
  }
  const SurfaceIndex fitted_index = make_index(fitted), truth_index = make_index(truth);

  const std::vector<int> seen = find_seen(truth, cloud, options.seen_mm);
  std::vector<Eigen::Vector3f> seen_positions;
  for (const int v : seen) seen_positions.push_back(truth.positions[v]);
  const std::vector<SurfaceHit> arrivals = fitted_index.find_nearest(seen_positions, kAnyDistance);
  Direction from_truth(labels), from_fitted(labels);
  RegionSorter by_truth_region(options.truth_regions);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    from_truth.add(nearest_corner(arrivals[i], fitted), arrivals[i].distance);
    by_truth_region.add(seen[i], arrivals[i].distance);
  }
  const std::vector<SurfaceHit> hits = truth_index.find_nearest(fitted.positions, kAnyDistance);
  for (std::size_t v = 0; v < hits.size(); ++v) from_fitted.add(static_cast<int>(v), hits[v].distance);

  SurfaceErrors errors;
  errors.truth_to_fitted = compute_error_stats(from_truth.all);
  errors.fitted_to_truth = compute_error_stats(from_fitted.all);
  errors.truth_to_fitted_by_region = from_truth.by_region.compute_stats();
  errors.fitted_to_truth_by_region = from_fitted.by_region.compute_stats();
  errors.truth_to_fitted_by_confidence = from_truth.confidence_stats();
  errors.fitted_to_truth_by_confidence = from_fitted.confidence_stats();
  errors.truth_to_fitted_by_truth_region = by_truth_region.compute_stats();
  return errors;
}

}  // namespace phiz
