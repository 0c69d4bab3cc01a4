#pragma once

#include <vector>

#include "formats/scan_file.h"
#include "formats/triangle_mesh.h"
#include "stages/geometry/surface_index.h"
#include "tests/bench/fitted.h"
#include "tests/bench/subjects.h"

namespace phiz::bench {

/// A synthetic subject's truth and scan, both in the truth's frame.
struct TruthScene {
  TriangleMesh truth;
  SurfaceIndex surface;  ///< of the whole truth, eyeballs too
  std::vector<Eigen::Vector3f> scan_points;
  std::vector<bool> is_used;  ///< false: a corner of no triangle in a scan that has triangles
};

TruthScene load_truth_scene(const BenchSubject& subject);

/// Mean distance, mm, of points to a surface.
double mean_distance(const std::vector<Eigen::Vector3f>& points, const SurfaceIndex& surface);

double box_diagonal(const std::vector<Eigen::Vector3f>& points);

/// How ingest dealt with the points of a raw scan.
struct IngestShares {
  double kept_above_neck = 0;  ///< of the points within 5 mm of the truth that lie above the neck plane
  double dropped_outliers =
      0;  ///< of the points farther than 5 mm from the truth, above the neck plane or not
  std::size_t outliers = 0;
};

/// A raw point counts as kept if the clean cloud has a point there (clouds), or within the spacing of the
/// samples (scans with triangles, whose clouds are drawn anew).
IngestShares measure_ingest(const BenchSubject& subject, const TruthScene& scene, const FittedHead& fitted,
                            const GenericHead& head);

/// Distances in mm at places spread by area over the true face and ears above the neck plane, hair left out, that have a
/// scan point within 1 mm.
struct SkinErrors {
  std::vector<double> surface;        ///< to the finished surface
  std::vector<double> point_medians;  ///< to the median plane of those points: the scanner's own noise
};

/// `finest` is the finished surface in the truth's frame.
SkinErrors measure_skin(const BenchSubject& subject, const TruthScene& scene, const TruthLabels& labels,
                        const FittedHead& fitted, const GenericHead& head, const SurfaceIndex& finest);

}  // namespace phiz::bench
