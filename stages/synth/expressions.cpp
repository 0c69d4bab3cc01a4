#include <Eigen/Geometry>

#include "stages/synth/anatomy.h"

namespace phiz {
namespace {

using Eigen::Vector3d;
using A = const Anatomy&;
using P = const Vector3d&;
using W = const RegionWeights&;

/// The line between the lips at x: through the middle and the corners, straight on beyond.
Vector3d lip_line(A a, double x) {
  const double t = std::min(1.0, std::abs(x) / a.mouth_corner.x());
  return a.stomion + t * t * (a.mouth_corner - a.stomion);
}

/// Share of a place in the movement of the lower jaw: 0 above the lips, 1 below, with a sharp step between
/// the lips, a wider one inside the mouth and a wide one in the cheeks; fades in the throat and before the
/// ears.
double jaw_share(A a, P p, W w) {
  const double beside = ramp(std::abs(p.x()), 0.7 * a.mouth_corner.x(), a.mouth_corner.x() + 30);
  const double behind = ramp(p.z(), a.mouth_corner.z() - 3, a.mouth_corner.z() - 30);
  const Vector3d line = lip_line(a, p.x());
  const double half_width = 1.3 + 12 * std::max(0.0, w.inner_mouth) + 24 * std::max(beside, behind);
  const double below = ramp(p.y(), line.y() + half_width, line.y() - half_width);
  const double before_ears = ramp(p.z(), a.tragus.z() - 5, a.tragus.z() + 45);
  return below * before_ears * ramp(p.y(), a.neck_low_y + 2, a.chin.y() - 4);
}

/// The jaw turns about the line through its joints, before the ears.
Vector3d jaw_open(A a, P p, W w) {
  const Vector3d joint(0, a.tragus.y() - 2, a.tragus.z() + 10);
  const Vector3d arm = p - joint;
  constexpr double kAngle = 0.21;
  const double c = std::cos(kAngle), s = std::sin(kAngle);
  const Vector3d turned(arm.x(), c * arm.y() - s * arm.z(), s * arm.y() + c * arm.z());
  const double chin_path = 2 * std::sin(0.5 * kAngle) * (a.chin - joint).tail<2>().norm();
  return jaw_share(a, p, w) * (turned - arm) / chin_path;
}

Vector3d mouth_smile(A a, P p, W) {
  return Vector3d(0.65, 0.75, -0.35) * bump(p, a.mouth_corner, 15, 13, 16) +
         Vector3d(0.1, 0.35, 0.3) * bump(p, a.cheek, 15, 15, 18);
}

Vector3d brow_inner_up(A a, P p, W) {
  return Vector3d(0, 0.85, 0.1) * bump(p, a.inner_brow, 12, 13, 18);
}

Vector3d mouth_pucker(A a, P p, W) {
  const Vector3d middle(0, a.stomion.y(), a.upper_lip.z());
  return Vector3d(-1, 0, 0.3) * bump(p, a.mouth_corner, 10, 12, 16) +
         Vector3d(0, 0, 0.3) * bump(p, middle, 14, 12, 14);
}

Vector3d eye_blink(A a, P p, W) {
  return Vector3d(0, -1, 0.12) * bump(p, a.eye_upper, 12, 4.5, 9) +
         Vector3d(0, 0.15, 0) * bump(p, a.eye - Vector3d(0, 6, 0), 12, 4, 9);
}

const VariationField kExpressions[] = {
    {{"jawOpen", 22.0, "lower jaw turned open: way of the chin"}, false, jaw_open},
    {{"mouthSmile", 8.0, "corners of the mouth up and out, cheeks up"}, true, mouth_smile},
    {{"browInnerUp", 6.0, "inner ends of the brows raised"}, true, brow_inner_up},
    {{"mouthPucker", 8.0, "corners of the mouth together, lips forward"}, true, mouth_pucker},
    {{"eyeBlink", 5.0, "upper lids down"}, true, eye_blink},
};

}  // namespace

std::span<const VariationField> expression_fields() {
  return kExpressions;
}

}  // namespace phiz
