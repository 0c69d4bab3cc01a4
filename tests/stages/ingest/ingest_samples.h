#pragma once

#include <cstdint>

#include "stages/ingest/ingest.h"
#include "stages/synth/synth.h"

namespace phiz::test {

const ControlMesh& generic_head();

/// A scan with noise, hair, shoulders and outliers of the subject of `seed`, in mm in the head's own frame.
/// Made once a run.
const PointCloud& subject_scan(std::uint64_t seed);

ScanFile make_scan(PointCloud points);

/// scan_from_truth applied to every point.
ScanFile posed(const PointCloud& cloud, const Eigen::Matrix4d& scan_from_truth);

/// How far the head frame that was found is from the true one.
struct PoseError {
  double turn_deg = 0, shift_mm = 0, scale = 1;
};
PoseError pose_error(const IngestResult& result, const Eigen::Matrix4d& scan_from_truth);

/// `count` points on shapes that are no heads.
PointCloud sphere_points(int count, double radius_mm);
PointCloud cube_points(int count, double side_mm);
PointCloud plane_points(int count, double side_mm);
PointCloud horse_points(int count);  ///< capsules: trunk, four legs, neck, head, tail

}  // namespace phiz::test
