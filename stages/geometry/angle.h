#pragma once

#include <numbers>

namespace phiz {

/// Angle in [0, pi] of two vectors with |a x b| = cross_norm >= 0 and a . b = dot: atan2(cross_norm, dot), 0
/// if both are 0. Error below 1e-11. Only + - * / and selections, so that loops over it become vector code
/// and every machine gives the same bits (std::atan2 does neither). Polynomial: interpolation of atan(t)/t at
/// 13 Chebyshev nodes in t^2.
inline double angle_of(double cross_norm, double dot) {
  const double across = dot < 0 ? -dot : dot;
  const bool steep = cross_norm > across;
  const double small = steep ? across : cross_norm;
  const double large = steep ? cross_norm : across;
  const double t = small / (large > 0 ? large : 1.0);
  const double s = t * t;
  double p = 0.00041921277387210954;
  p = p * s - 0.003195334243803069;
  p = p * s + 0.01142739179956082;
  p = p * s - 0.026005625216594826;
  p = p * s + 0.04364622506839693;
  p = p * s - 0.06022172442785981;
  p = p * s + 0.07495251704942628;
  p = p * s - 0.0904917588909659;
  p = p * s + 0.11105306102176453;
  p = p * s - 0.14285225531444168;
  p = p * s + 0.199999783310288;
  p = p * s - 0.33333332951502337;
  p = p * s + 0.9999999999887283;
  const double angle = t * p;
  const double folded = steep ? std::numbers::pi / 2 - angle : angle;
  return dot < 0 ? std::numbers::pi - folded : folded;
}

}  // namespace phiz
