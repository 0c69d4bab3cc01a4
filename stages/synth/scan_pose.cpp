#include <Eigen/Geometry>
#include <numbers>

#include "stages/synth/random_stream.h"
#include "stages/synth/synth.h"

namespace phiz {
namespace {

constexpr double kMostTurn = 20 * std::numbers::pi / 180, kMostShiftMm = 400;

/// One of the 24 rotations that map axes to axes.
Eigen::Matrix3d draw_axis_orientation(RandomStream& random) {
  const int first = static_cast<int>(random.next() % 3), turn = 1 + static_cast<int>(random.next() % 2);
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Zero();
  rotation(first, 0) = random.next() % 2 ? 1 : -1;
  rotation((first + turn) % 3, 1) = random.next() % 2 ? 1 : -1;
  rotation.col(2) = rotation.col(0).cross(rotation.col(1));
  return rotation;
}

}  // namespace

Eigen::Matrix4d draw_scan_pose(std::uint64_t seed, double units_per_mm) {
  RandomStream random({seed, 0x706f7365});
  const Eigen::Matrix3d orientation = draw_axis_orientation(random);
  Eigen::Vector3d axis, shift;
  for (int i = 0; i < 3; ++i) axis[i] = random.normal();
  for (int i = 0; i < 3; ++i) shift[i] = random.uniform(-kMostShiftMm, kMostShiftMm);
  const Eigen::AngleAxisd tilt(random.uniform(0, kMostTurn), axis.normalized());
  Eigen::Matrix4d scan_from_truth = Eigen::Matrix4d::Identity();
  scan_from_truth.topLeftCorner<3, 3>() = units_per_mm * (tilt.toRotationMatrix() * orientation);
  scan_from_truth.topRightCorner<3, 1>() = units_per_mm * shift;
  return scan_from_truth;
}

}  // namespace phiz
