#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "stages/publish/views.h"

namespace phiz {

inline constexpr int kSamples = 3;  ///< samples a pixel along each axis

/// Orthographic map from mm to samples: x right, y down, z towards the viewer (larger is nearer), all in
/// samples.
struct Screen {
  Eigen::Matrix3f rotation;  ///< rows: right, up, towards the viewer
  Eigen::Vector3f centre_mm;
  float samples_per_mm = 1;
  int width = 0, height = 0;  ///< in samples

  Eigen::Vector3f project(const Eigen::Vector3f& position_mm) const;
};

/// Throws InvalidInput if the picture's size is out of range or an explicit frame is empty or not finite.
/// Without a frame the box of the finite positions is taken, widened by 3 %; if `robust`, that of the central
/// 99 % on each axis, widened by 10 %, so that a scan's outliers do not shrink its head.
Screen make_screen(const ViewOptions& options, std::span<const Eigen::Vector3f> positions, bool robust);

}  // namespace phiz
