#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <span>
#include <vector>

#include "formats/control_mesh.h"
#include "formats/deformation.h"
#include "stages/deform/deform.h"

namespace phiz {

struct TrackOptions {
  int points = 40'000;          ///< of a scan that are looked at, drawn evenly
  int rounds = 8;               ///< of matching and solving a frame
  double first_reach_mm = 10;   ///< farthest match in the first round of a frame
  double last_reach_mm = 2;     ///< and in the last
  double least_noise_mm = 0.1;  ///< of the scan: what robust weights start from
  double neutral_sigma = 0.25;  ///< what is expected of a control that the scan says nothing about
  double last_sigma = 0.1;      ///< and of its change between frames
};

/// One frame: values of the rig's controls, and where the head is.
struct TrackedFrame {
  std::vector<float> controls;                                       ///< in [0, limit of their parameters]
  Eigen::Isometry3d scan_from_head = Eigen::Isometry3d::Identity();  ///< mm
  double residual_mm = 0;  ///< root mean square of the matches that count
  int matches = 0;
};

/// From scans of one fitted subject to the controls of a rig and the pose of the head: non-linear least
/// squares (Gauss-Newton within bounds) of point-to-plane distances with Tukey's weights, from scan points to
/// the posed surface, over face and ears without eyes, nostrils and the inside of the mouth. Derivatives in
/// the controls are central differences of the compiled cascade. Each frame starts from the last.
/// Deterministic at any number of threads. About 0.4 s a frame of 40,000 points.
class Tracker {
 public:
  /// `neutral` from `maker`, of that subject. Throws as CompiledCascade does; InvalidInput where the head
  /// lacks the regions eyes, nostrils, inner_mouth, scalp or neck.
  Tracker(const Deformation& rig, const ControlMesh& generic_head, const NeutralMaker& maker,
          NeutralSurface neutral, const TrackOptions& options = {});
  ~Tracker();

  /// Points in mm, about in the head frame; without normals. Throws InvalidInput where fewer than 500 of them
  /// lie near the face.
  TrackedFrame track(std::span<const Eigen::Vector3f> points);

  /// Goes on from a frame that an earlier tracker of the same making has returned.
  void resume(const TrackedFrame& last);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace phiz
