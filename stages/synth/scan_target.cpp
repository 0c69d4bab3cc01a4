#include <algorithm>
#include <cmath>

#include "stages/geometry/error.h"
#include "stages/geometry/normals.h"
#include "stages/synth/anatomy.h"
#include "stages/synth/random_stream.h"
#include "stages/synth/value_noise.h"

namespace phiz {
namespace {

using Eigen::Vector3d;

constexpr int kShoulderRings = 40;
const Vector3d kHairColour(66, 48, 36), kLipColour(176, 96, 92), kBrowColour(72, 54, 42),
    kClothColour(92, 104, 122), kEyeWhite(226, 222, 216), kIris(84, 104, 92);

/// Where the shoulders end in a direction around the neck, and the pull of the curve that leads there.
struct ShoulderCurve {
  Vector3d start, leave, arrive, end;
  Vector3d at(double t) const {
    const double s = 1 - t;
    return s * s * s * start + 3 * s * s * t * leave + 3 * s * t * t * arrive + t * t * t * end;
  }
};

ShoulderCurve make_shoulder_curve(const Vector3d& start, double neck_axis_z) {
  Vector3d out(start.x(), 0, start.z() - neck_axis_z);
  out.normalize();
  const double side = std::abs(out.x());
  const double depth = out.z() > 0 ? 85 : 100;
  ShoulderCurve curve;
  curve.start = start;
  curve.leave = start + Vector3d(4 * out.x(), -34, 4 * out.z());
  curve.arrive = {185 * out.x(), -150 - 12 * side, neck_axis_z - 8 + depth * out.z()};
  curve.end = {208 * out.x(), -290, neck_axis_z - 8 + 1.05 * depth * out.z()};
  return curve;
}

void add_shoulders(const std::vector<int>& loop, double neck_axis_z, ScanTarget& target) {
  const int width = static_cast<int>(loop.size());
  std::vector<int> last = loop;
  std::vector<ShoulderCurve> curves;
  for (const int v : loop) {
    curves.push_back(make_shoulder_curve(target.mesh.positions[v].cast<double>(), neck_axis_z));
  }
  for (int ring = 1; ring <= kShoulderRings; ++ring) {
    std::vector<int> row(width);
    for (int i = 0; i < width; ++i) {
      row[i] = static_cast<int>(target.mesh.positions.size());
      target.mesh.positions.push_back(curves[i].at(double(ring) / kShoulderRings).cast<float>());
      target.materials.push_back(ring > 8 ? ScanMaterial::kCloth : ScanMaterial::kSkin);
    }
    for (int i = 0; i < width; ++i) {
      const int j = (i + 1) % width;  // the border runs from i to j in the head, so from j to i here
      target.mesh.triangles.push_back({last[j], last[i], row[i]});
      target.mesh.triangles.push_back({last[j], row[i], row[j]});
    }
    last = row;
  }
}

double distance_to_polyline(const Vector3d& p, const std::vector<Vector3d>& line) {
  double best = 1e300;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Vector3d edge = line[i + 1] - line[i];
    const double t = std::clamp((p - line[i]).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    best = std::min(best, (p - line[i] - t * edge).norm());
  }
  return best;
}

Vector3d mix(const Vector3d& a, const Vector3d& b, double t) {
  return a + std::clamp(t, 0.0, 1.0) * (b - a);
}

Vector3d landmark(const SubjectBase& base, const std::string& name) {
  const auto found = base.landmarks.find(name);
  if (found == base.landmarks.end()) throw InvalidInput("the generic head has no landmark '" + name + "'");
  return position_at(found->second, base.triangles, base.positions);
}

/// The left eye's opening seen from the front, a lens between the landmarks of the lids; right by mirroring.
class EyeOpening {
 public:
  explicit EyeOpening(const SubjectBase& base) {
    const Vector3d inner = landmark(base, "eye_left_inner_corner"),
                   outer = landmark(base, "eye_left_outer_corner");
    const Vector3d upper = landmark(base, "eye_left_upper_inner") + landmark(base, "eye_left_upper_outer");
    const Vector3d lower = landmark(base, "eye_left_lower_inner") + landmark(base, "eye_left_lower_outer");
    middle_ = 0.5 * (inner + outer);
    middle_.y() = 0.25 * (upper + lower).y();
    half_width_ = 0.5 * std::abs(outer.x() - inner.x());
    half_height_ = 0.25 * std::abs(upper.y() - lower.y()) * 1.1;
  }

  Vector3d offset(const Vector3d& p) const { return Vector3d(std::abs(p.x()), p.y(), p.z()) - middle_; }
  bool contains(const Vector3d& p) const {
    const Vector3d off = offset(p);
    const double across = off.x() / half_width_;
    return std::abs(off.z()) < 12 && std::abs(off.y()) < half_height_ * (1 - across * across);
  }

 private:
  Vector3d middle_;
  double half_width_ = 1, half_height_ = 1;
};

/// Colours of the subject's own vertices, from the place on the generic head.
class SkinPainter {
 public:
  SkinPainter(const SubjectBase& base, std::uint64_t seed) : base_(base), opening_(base), noise_(seed) {
    RandomStream random({seed, 0x736b696e});
    tone_ = mix({232, 196, 172}, {142, 98, 74}, random.uniform());
    for (const std::string side : {"left", "right"}) {
      std::vector<Vector3d> line;
      for (int i = 0; i < 5; ++i) line.push_back(landmark(base, "brow_" + side + "_" + std::to_string(i)));
      brows_.push_back(line);
    }
  }

  Vector3d paint(std::size_t v, ScanMaterial material) const {
    const Vector3d& p = base_.positions[v];
    Vector3d colour = tone_ * (1 + 0.05 * (noise_.at(p / 6) - 0.5) + 0.06 * (noise_.at(p / 25) - 0.5));
    colour = mix(colour, kLipColour, 0.75 * (base_.regions.at("lips")[v] - 0.4) / 0.35);
    for (const auto& brow : brows_) {
      colour = mix(colour, kBrowColour, 0.85 * (5.5 - distance_to_polyline(p, brow)) / 2.5);
    }
    if (material == ScanMaterial::kEye) {
      const double off = opening_.offset(p).head<2>().norm();
      colour = off < 2.2 ? Vector3d(24, 22, 22) : off < 5.2 ? kIris : kEyeWhite;
    }
    if (material == ScanMaterial::kHair) colour = kHairColour * (0.8 + 0.4 * noise_.at(p / 4));
    return colour;
  }

 private:
  const SubjectBase& base_;
  EyeOpening opening_;
  ValueNoise noise_;
  Vector3d tone_;
  std::vector<std::vector<Vector3d>> brows_;
};

}  // namespace

ScanTarget make_scan_target(const SubjectBase& base, std::span<const Eigen::Vector3d> positions,
                            const ScanTargetOptions& options) {
  CONTRACT(positions.size() == base.positions.size());
  ScanTarget target;
  target.mesh.triangles = base.triangles;
  const std::vector<double>& scalp = base.regions.at("scalp");
  const EyeOpening opening(base);
  for (std::size_t v = 0; v < positions.size(); ++v) {
    target.mesh.positions.push_back(positions[v].cast<float>());
    const bool is_hair = options.has_hair && scalp[v] > 0.5;
    target.materials.push_back(is_hair                               ? ScanMaterial::kHair
                               : opening.contains(base.positions[v]) ? ScanMaterial::kEye
                                                                     : ScanMaterial::kSkin);
  }
  if (options.has_shoulders) add_shoulders(base.neck_loop, measure_anatomy(base).neck_axis_z, target);

  const SkinPainter painter(base, options.seed);
  const auto normals = compute_vertex_normals(target.mesh.positions, target.mesh.triangles);
  const Vector3d skin = painter.paint(base.neck_loop.front(), ScanMaterial::kSkin);
  for (std::size_t v = 0; v < target.mesh.positions.size(); ++v) {
    Vector3d colour = v < positions.size()                          ? painter.paint(v, target.materials[v])
                      : target.materials[v] == ScanMaterial::kCloth ? kClothColour
                                                                    : skin;
    colour *= 0.86 + 0.14 * normals[v].cast<double>().dot(Vector3d(0.2, 0.6, 0.77));
    std::array<std::uint8_t, 3> bytes;
    for (int i = 0; i < 3; ++i) bytes[i] = static_cast<std::uint8_t>(std::clamp(colour[i], 0.0, 255.0));
    target.mesh.colours.push_back(bytes);
  }
  return target;
}

}  // namespace phiz
