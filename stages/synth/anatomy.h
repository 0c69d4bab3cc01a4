#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "stages/synth/synth.h"

namespace phiz {

/// Places of the generic head that the fields are built around: midline ones have x = 0, others lie on the
/// subject's left. Fields of the right side are mirror images.
struct Anatomy {
  Eigen::Vector3d eye, eye_upper, brow, inner_brow;
  Eigen::Vector3d sellion, bridge, nose_tip, subnasale, ala;
  Eigen::Vector3d upper_lip, lower_lip, stomion, mouth_corner;
  Eigen::Vector3d chin, jaw_angle, cheekbone, cheek;
  Eigen::Vector3d tragus, ear_lobe, ear_top;
  double crown_y = 0, back_z = 0, neck_low_y = 0, neck_axis_z = 0;
};

/// Throws InvalidInput where a landmark is missing.
Anatomy measure_anatomy(const SubjectBase& base);

/// Weights of a vertex in regions whose fields follow the surface and not just the place.
struct RegionWeights {
  double ear = 0, neck = 0, inner_mouth = 0;
};

/// Displacement at value 1 in units of the amplitude. `p` is the place on the generic head.
using Field = Eigen::Vector3d (*)(const Anatomy& a, const Eigen::Vector3d& p, const RegionWeights& w);

/// A field that is given for the left side only is completed by its mirror image.
struct VariationField {
  Variation variation;
  bool is_left_half = false;
  Field field = nullptr;
};

std::span<const VariationField> slider_fields();
std::span<const VariationField> expression_fields();

/// 0 below `from`, 1 above `to`, with continuous curvature between; `from` may be the larger one.
inline double ramp(double x, double from, double to) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * t * (10 + t * (6 * t - 15));
}

/// A Gaussian bump about `centre`, 1 there, with a sigma per axis.
inline double bump(const Eigen::Vector3d& p, const Eigen::Vector3d& centre, double rx, double ry, double rz) {
  const Eigen::Vector3d q = (p - centre).cwiseQuotient(Eigen::Vector3d(rx, ry, rz));
  return std::exp(-0.5 * q.squaredNorm());
}

inline Eigen::Vector3d mirrored(const Eigen::Vector3d& p) {
  return {-p.x(), p.y(), p.z()};
}

}  // namespace phiz
