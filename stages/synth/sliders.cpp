#include "stages/synth/anatomy.h"

// Amplitudes are round figures in the order of one standard deviation of adults.

namespace phiz {
namespace {

using Eigen::Vector3d;
using A = const Anatomy&;
using P = const Vector3d&;
using W = const RegionWeights&;

/// 1 on the face, 0 behind the ears.
double front(A a, P p) {
  return ramp(p.z(), a.tragus.z() - 5, a.tragus.z() + 60);
}
/// 1 above the jaw, 0 in the neck, for what belongs to the skull.
double skull(A a, P p) {
  return ramp(p.y(), a.stomion.y() - 40, a.tragus.y() + 25);
}

Vector3d head_size(A a, P p, W) {
  return (p - a.tragus.cwiseProduct(Vector3d(0, 1, 1))) / 110;
}
Vector3d head_width(A a, P p, W) {
  return {skull(a, p) * p.x() / 75, 0, 0};
}
Vector3d head_length(A a, P p, W) {
  return {0, 0, -ramp(p.z(), 10, a.back_z + 5) * ramp(p.y(), a.neck_low_y + 15, a.ear_lobe.y() + 25)};
}
Vector3d crown_height(A a, P p, W) {
  return {0, ramp(p.y(), a.brow.y() - 5, a.crown_y), 0};
}
Vector3d forehead_slope(A a, P p, W) {
  const Vector3d centre(0, 0.55 * a.brow.y() + 0.45 * a.crown_y, a.brow.z());
  return {0, 0, -bump(p, centre, 60, 24, 40)};
}
Vector3d brow_ridge(A a, P p, W) {
  return Vector3d(0, -0.15, 0.75) * bump(p, a.brow, 19, 9, 20);
}
Vector3d face_height(A a, P p, W) {
  const double below_eyes = ramp(p.y(), a.eye.y(), a.chin.y());
  return {0, -below_eyes * front(a, p) * ramp(p.y(), a.chin.y() - 40, a.chin.y() + 5), 0};
}
Vector3d face_width(A a, P p, W) {
  return Vector3d(1, 0, 0.25) * bump(p, a.cheekbone, 22, 26, 30);
}
Vector3d cheek_fullness(A a, P p, W) {
  return Vector3d(0.75, -0.05, 0.65) * bump(p, a.cheek, 17, 22, 22);
}
Vector3d jaw_width(A a, P p, W) {
  return Vector3d(1, 0, 0) * bump(p, a.jaw_angle, 26, 26, 34);
}
Vector3d chin_projection(A a, P p, W) {
  return Vector3d(0, -0.1, 1) * bump(p, a.chin, 24, 20, 28);
}
Vector3d chin_width(A a, P p, W) {
  return Vector3d(1, 0, 0) * bump(p, a.chin + Vector3d(22, 6, -8), 13, 18, 22);
}
Vector3d nose_length(A a, P p, W) {
  return Vector3d(0, -1, 0) * bump(p, 0.5 * (a.subnasale + a.nose_tip), 16, 15, 22);
}
Vector3d nose_projection(A a, P p, W) {
  return Vector3d(0, 0, 1) * bump(p, a.nose_tip, 13, 16, 20);
}
Vector3d nose_width(A a, P p, W) {
  return Vector3d(1.15, 0, 0) * bump(p, a.ala + Vector3d(3, 3, 0), 8, 10, 13);
}
Vector3d nose_bridge(A a, P p, W) {
  return Vector3d(0, 0, 1) * bump(p, a.bridge, 8, 13, 18);
}
Vector3d eye_spacing(A a, P p, W) {
  return Vector3d(1, 0, 0) * bump(p, a.eye, 17, 15, 24);
}
Vector3d eye_depth(A a, P p, W) {
  return Vector3d(0, 0, -1) * bump(p, a.eye, 15, 11, 20);
}
Vector3d mouth_width(A a, P p, W) {
  return Vector3d(1, 0, 0) * bump(p, a.mouth_corner, 12, 11, 16);
}
Vector3d lip_fullness(A a, P p, W) {
  return Vector3d(0, 0.45, 1) * bump(p, a.upper_lip, 15, 6, 10) +
         Vector3d(0, -0.45, 1) * bump(p, a.lower_lip, 14, 6.5, 10);
}
Vector3d ear_size(A a, P p, W w) {
  if (p.x() <= 0) return Vector3d::Zero();
  return w.ear * (p - a.tragus) / 40;
}
Vector3d ear_protrusion(A a, P p, W w) {
  if (p.x() <= 0) return Vector3d::Zero();
  const double behind = a.tragus.z() - p.z();
  return w.ear * ramp(p.z(), a.tragus.z() + 4, a.tragus.z() - 26) * Vector3d(1, 0, 0.1 + behind / 200);
}
Vector3d neck_width(A a, P p, W w) {
  const Vector3d out(p.x(), 0, p.z() - a.neck_axis_z);
  return w.neck * ramp(p.y(), a.chin.y() + 45, a.neck_low_y + 10) * out / 55;
}

const VariationField kSliders[] = {
    {{"head_size", 3.0, "everything larger about the ears: mm at 110 mm distance"}, false, head_size},
    {{"head_width", 3.0, "skull wider, each side"}, false, head_width},
    {{"head_length", 7.0, "back of the head farther back"}, false, head_length},
    {{"crown_height", 5.0, "crown higher above the brows"}, false, crown_height},
    {{"forehead_slope", 3.0, "forehead recedes"}, false, forehead_slope},
    {{"brow_ridge", 2.0, "brows stand forward"}, true, brow_ridge},
    {{"face_height", 5.0, "eyes to chin longer"}, false, face_height},
    {{"face_width", 2.5, "cheekbones wider, each side"}, true, face_width},
    {{"cheek_fullness", 3.0, "cheeks fuller"}, true, cheek_fullness},
    {{"jaw_width", 3.5, "angles of the jaw wider, each side"}, true, jaw_width},
    {{"chin_projection", 3.5, "chin farther forward"}, false, chin_projection},
    {{"chin_width", 2.0, "chin broader, each side"}, true, chin_width},
    {{"nose_length", 2.5, "base of the nose lower"}, false, nose_length},
    {{"nose_projection", 2.0, "tip of the nose farther forward"}, false, nose_projection},
    {{"nose_width", 1.5, "wings of the nose wider, each side"}, true, nose_width},
    {{"nose_bridge", 1.8, "bridge of the nose higher"}, false, nose_bridge},
    {{"eye_spacing", 1.5, "eyes farther apart, each side"}, true, eye_spacing},
    {{"eye_depth", 1.5, "eyes lie deeper"}, true, eye_depth},
    {{"mouth_width", 2.0, "corners of the mouth farther out, each side"}, true, mouth_width},
    {{"lip_fullness", 1.3, "lips fuller"}, false, lip_fullness},
    {{"ear_size", 2.5, "ears larger about the tragus: mm at 40 mm distance"}, true, ear_size},
    {{"ear_protrusion", 3.0, "rims of the ears stand off"}, true, ear_protrusion},
    {{"neck_width", 4.0, "neck thicker all round"}, false, neck_width},
};

}  // namespace

std::span<const VariationField> slider_fields() {
  return kSliders;
}

}  // namespace phiz
