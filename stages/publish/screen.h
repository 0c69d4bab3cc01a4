#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "stages/publish/views.h"

namespace phiz {

/// Orthographic map from mm to samples: x right, y down, z towards the viewer (larger is nearer), all in
/// samples.
struct Screen {
  Eigen::Matrix3f rotation;  ///< rows: right, up, towards the viewer
  Eigen::Vector3f centre_mm;
  float samples_per_mm = 1;
  int samples = 3;            ///< a pixel, along each axis
  int width = 0, height = 0;  ///< in samples

  Eigen::Vector3f project(const Eigen::Vector3f& position_mm) const;
};

/// What the object is asks for how it is sampled and framed.
struct ScreenStyle {
  int samples = 3;
  bool robust = false;  ///< without a frame: the box of the central 99 % on each axis, widened by 10 %, so
                        ///< that a scan's outliers do not shrink its head; else the box of the finite
                        ///< positions, widened by 3 %
};

/// The box of the central 99 % on each axis of the finite positions; empty if there are none.
Eigen::AlignedBox3f find_robust_box(std::span<const Eigen::Vector3f> positions);

/// Throws InvalidInput if the picture's size is out of range or an explicit frame is empty or not finite.
Screen make_screen(const ViewOptions& options, std::span<const Eigen::Vector3f> positions,
                   const ScreenStyle& style);

}  // namespace phiz
