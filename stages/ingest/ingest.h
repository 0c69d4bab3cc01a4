#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "formats/control_mesh.h"
#include "formats/distance_field.h"
#include "formats/point_cloud.h"
#include "formats/scan_file.h"

namespace phiz {

struct IngestOptions {
  std::optional<double> mm_per_unit;  ///< stated unit of the scan; empty: found from the size of the head
  int soup_samples = 300'000;         ///< points drawn by area from a scan that has triangles
  int max_points = 1'000'000;         ///< larger clouds are thinned evenly; 0: keep all
  double neck_margin_mm = 0.0;        ///< how far below the generic head's neck plane points are kept
  double field_voxel_mm = 2.0;        ///< lattice of the distance field
  double reject_score = 0.42;         ///< pose score above which the scan is called "not a head"
  double reject_mismatch = 0.70;      ///< the same for the sharpened pose, with normals
};

/// What was assumed and what was removed, for people.
struct IngestSummary {
  std::size_t points_read = 0, points_sampled = 0, points_kept = 0;
  std::size_t removed_non_finite = 0, removed_outliers = 0, removed_below_neck = 0, removed_far = 0;
  double mm_per_unit = 1;
  std::string unit;       ///< "mm", "cm", "m", "in", "stated" or "unknown" (scaled to the generic head)
  double head_scale = 1;  ///< size of this head over the generic head's
  double pose_score = 0;  ///< mean truncated distance over truncation, both ways: 0 perfect, 1 nothing fits
  double pose_mismatch = 0;    ///< the same for the sharpened pose, with normals
  double turned_deg = 0;       ///< rotation between the scan's axes and the head's
  double coverage = 0;         ///< share of the generic head's outer surface that the scan saw
  double noise_mm = 0;         ///< median distance of a point to the plane of its neighbours
  double density_per_mm2 = 0;  ///< median over the cloud
};

struct IngestResult {
  PointCloud cloud;  ///< head frame: mm, +y up, +z forward; normals outward, confidence, colour kept
  Eigen::Matrix4d scan_from_head;  ///< head mm -> the scan's frame and units
  double head_scale = 1;  ///< uniform scale that brings the generic head onto the cloud, about the origin
  DistanceField distance_field;
  IngestSummary summary;
};

/// An ingest between two of its steps: what one that was interrupted continues with.
struct IngestState {
  PointCloud cloud;  ///< head frame; placed: without normals
  Eigen::Matrix4d scan_from_head = Eigen::Matrix4d::Identity();
  double head_scale = 1;
  float spacing_mm = 0;
  IngestSummary summary;
};

/// Raw scan to a clean, upright head in mm, whatever its axes and units. The head frame is the generic head's
/// own: its similarity transform onto the scan is searched over all rotations (truncated distance both ways
/// on distance lattices, then Gauss-Newton), so shoulders, stands and long necks are told apart from the head
/// by shape and cut at the generic head's neck plane. Throws InvalidInput where there
/// are too few points, FitRejected where there is no head.
/// Deterministic. About 0.7 s and 150 bytes a point for 300,000 points on two threads.
IngestResult ingest(const ScanFile& scan, const ControlMesh& generic_head, const IngestOptions& options = {});

// The same in three steps, about half, a third and a sixth of the time: finds the head and cuts it out;
// estimates normals and confidences; measures the distance field.
IngestState place_head(const ScanFile& scan, const ControlMesh& generic_head,
                       const IngestOptions& options = {});
void orient_points(const ControlMesh& generic_head, IngestState& state);
IngestResult finish_ingest(const ControlMesh& generic_head, const IngestOptions& options, IngestState state);

}  // namespace phiz
