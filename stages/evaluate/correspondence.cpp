#include <limits>

#include "stages/evaluate/evaluate.h"
#include "stages/evaluate/sorter.h"
#include "stages/geometry/error.h"
#include "stages/geometry/surface_index.h"

namespace phiz {

CorrespondenceErrors compute_correspondence_errors(const CorrespondencePair& pair,
                                                   const CorrespondenceOptions& options) {
  if (pair.fitted_a.size() != pair.fitted_b.size()) {
    throw InvalidInput("the two fits have different numbers of vertices",
                       "fit both with the same generic head");
  }
  if (pair.truth_a.size() != pair.truth_b.size()) {
    throw InvalidInput("the two truths have different numbers of vertices");
  }
  if (pair.truth_triangles.empty()) throw InvalidInput("the truth has no triangle");
  check_regions(options.regions, pair.fitted_a.size());
  check_regions(options.truth_regions, pair.truth_a.size());

  const SurfaceIndex index(pair.truth_a, pair.truth_triangles);
  const std::vector<SurfaceHit> hits = index.find_nearest(pair.fitted_a, options.reach_mm);
  CorrespondenceErrors errors;
  RegionSorter by_region(options.regions), by_truth_region(options.truth_regions);
  std::vector<double> counted;
  for (std::size_t v = 0; v < hits.size(); ++v) {
    errors.distances_mm.push_back(std::numeric_limits<double>::quiet_NaN());
    if (hits[v].triangle_idx < 0) continue;
    const Eigen::Vector3i& triangle = pair.truth_triangles[hits[v].triangle_idx];
    Eigen::Vector3d carried = Eigen::Vector3d::Zero();
    for (int i = 0; i < 3; ++i) carried += hits[v].weights[i] * pair.truth_b[triangle[i]].cast<double>();
    const double distance = (carried - pair.fitted_b[v].cast<double>()).norm();
    int corner = 0;
    hits[v].weights.maxCoeff(&corner);
    errors.distances_mm.back() = distance;
    counted.push_back(distance);
    by_region.add(static_cast<int>(v), distance);
    by_truth_region.add(triangle[corner], distance);
  }
  errors.all = compute_error_stats(counted);
  errors.by_region = by_region.compute_stats();
  errors.by_truth_region = by_truth_region.compute_stats();
  return errors;
}

}  // namespace phiz
