#include "stages/deform/muscle_shapes.h"

#include <algorithm>
#include <cmath>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// 0 below -1, 1 above 1, without a corner.
double smooth_step(double x) {
  const double t = std::clamp(0.5 * (x + 1), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

template <typename Value>
const Value& get(const std::map<std::string, Value>& landmarks, const std::string& name) {
  const auto found = landmarks.find(name);
  if (found == landmarks.end()) throw InvalidInput("the generic head has no landmark '" + name + "'");
  return found->second;
}

Vector3d place_of(const LandmarkPoint& point, const UvCanvas& canvas) {
  if (point.empty()) throw InvalidInput("a place without landmarks");
  Vector3d place = Vector3d::Zero();
  double sum = 0;
  for (const auto& [name, weight] : point) {
    place += weight * get(canvas.landmarks, name);
    sum += weight;
  }
  if (!(std::abs(sum - 1) < 1e-6)) throw InvalidInput("weights of landmarks do not sum to 1");
  return place;
}

double radius_of(const Vector3d& p, const Vector3d& centre, const Vector3d& radii) {
  return (p - centre).cwiseQuotient(radii).norm();
}

class Painter {
 public:
  Painter(const UvCanvas& canvas, std::vector<Vector3d>& values) : canvas_(canvas), values_(values) {}

  void pull(const MusclePull& pull) {
    const Vector3d centre = place_of(pull.centre, canvas_);
    Vector3d way = Vector3d::Zero();
    if (pull.amplitude_mm != 0) {
      const Vector3d direction =
          pull.toward ? (place_of(*pull.toward, canvas_) - centre).eval() : pull.direction;
      way = pull.amplitude_mm * direction.normalized();
    }
    over_nodes([&](std::size_t node) {
      const Vector3d& p = canvas_.positions[node];
      const double radius = radius_of(p, centre, pull.radii_mm);
      if (radius >= 1) return;
      const Vector3d inward = -pull.shrink.cwiseProduct(p - centre);
      values_[node] += falloff(radius, pull.plateau) * (way + pull.bulge_mm * canvas_.normals[node] + inward);
    });
  }

  void close(const MuscleLids& lids) {
    const Curve upper = curve_of(lids.upper), lower = curve_of(lids.lower);
    const Vector3d from = upper.places.front(), along = upper.places.back() - from;
    const double length = along.norm();
    const double back = std::min(from.z(), upper.places.back().z()) - kBehindMm;  // not the back of the head
    over_nodes([&](std::size_t node) {
      const Vector3d& p = canvas_.positions[node];
      const double s = (p - from).dot(along) / (length * length);
      if (s <= -0.2 || s >= 1.2 || p.z() < back) return;
      const double inside = std::clamp(s, 0.0, 1.0);
      const Vector3d top = upper.at(inside), bottom = lower.at(inside), gap = top - bottom;
      const double ends = falloff(std::max(0.0, std::max(-s, s - 1) / 0.2), 0);
      const double above = p.y() - top.y(), below = bottom.y() - p.y();
      // A little beyond each margin the lid turns inwards and moves with it; the eye itself stays.
      if (above > -kMarginMm)
        values_[node] -= (1 - lids.meet) * lids.amount * ends *
                         falloff(std::max(0.0, above) / lids.upper_reach_mm, 0.1) * gap;
      else if (below > -kMarginMm)
        values_[node] +=
            lids.meet * lids.amount * ends * falloff(std::max(0.0, below) / lids.lower_reach_mm, 0.1) * gap;
    });
  }

  void mask(const ControlMesh& head, const MuscleMask& mask) {
    std::vector<double> region;
    if (mask.kind == MuscleMask::Kind::kRegion)
      region = draw_region(head, canvas_.side, {mask.region, mask.shrink, mask.rings});
    const bool has_place = mask.kind == MuscleMask::Kind::kPlane || mask.kind == MuscleMask::Kind::kEllipsoid;
    const Vector3d place = has_place ? place_of(mask.point, canvas_) : Vector3d::Zero();
    over_nodes([&](std::size_t node) {
      double share = 0;
      switch (mask.kind) {
        case MuscleMask::Kind::kPlane:
          share =
              smooth_step(((canvas_.positions[node] - place).dot(mask.normal.normalized()) - mask.offset_mm) /
                          mask.blend_mm);
          break;
        case MuscleMask::Kind::kRegion:
          share = std::clamp(region[node], 0.0, 1.0);
          break;
        case MuscleMask::Kind::kBelowCurve:
          share = share_below(mask, node);
          break;
        case MuscleMask::Kind::kEllipsoid:
          share = falloff(radius_of(canvas_.positions[node], place, mask.radii_mm), mask.plateau);
          break;
      }
      values_[node] *= mask.is_inverted ? 1 - share : share;
    });
  }

 private:
  static constexpr double kMarginMm = 1.0, kBehindMm = 15.0;

  struct Curve {
    std::vector<Vector3d> places;
    std::vector<double> knots;  ///< 0 .. 1 along the line between the ends
    Vector3d at(double s) const {
      std::size_t i = 0;
      while (i + 2 < knots.size() && knots[i + 1] < s) ++i;
      // Cubic Hermite with slopes of neighbours (Catmull-Rom), uneven knots.
      const auto slope = [&](std::size_t k) {
        const std::size_t a = k == 0 ? 0 : k - 1, b = std::min(k + 1, knots.size() - 1);
        return ((places[b] - places[a]) / (knots[b] - knots[a])).eval();
      };
      const double h = knots[i + 1] - knots[i], t = std::clamp((s - knots[i]) / h, 0.0, 1.0);
      const double t2 = t * t, t3 = t2 * t;
      return (2 * t3 - 3 * t2 + 1) * places[i] + (t3 - 2 * t2 + t) * h * slope(i) +
             (3 * t2 - 2 * t3) * places[i + 1] + (t3 - t2) * h * slope(i + 1);
    }
  };

  Curve curve_of(const std::vector<std::string>& names) const {
    Curve curve;
    for (const std::string& name : names) curve.places.push_back(get(canvas_.landmarks, name));
    const Vector3d along = curve.places.back() - curve.places.front();
    for (const Vector3d& place : curve.places)
      curve.knots.push_back((place - curve.places.front()).dot(along) / along.squaredNorm());
    for (std::size_t i = 1; i < curve.knots.size(); ++i) {
      if (!(curve.knots[i] > curve.knots[i - 1] + 1e-3))
        throw InvalidInput("landmarks of a lid do not go from corner to corner");
    }
    return curve;
  }

  double share_below(const MuscleMask& mask, std::size_t node) const {
    const Vector2d uv =
        canvas_.uv(static_cast<int>(node % canvas_.side), static_cast<int>(node / canvas_.side));
    const std::size_t last = mask.curve.size() - 1;
    std::size_t i = 0;
    while (i + 1 < last && get(canvas_.landmark_uv, mask.curve[i + 1]).x() < uv.x()) ++i;
    const Vector2d a = get(canvas_.landmark_uv, mask.curve[i]),
                   b = get(canvas_.landmark_uv, mask.curve[i + 1]);
    if (!(b.x() > a.x())) throw InvalidInput("landmarks of a curve do not go on in u");
    const double t = (uv.x() - a.x()) / (b.x() - a.x());
    const Vector2d inner_left = get(canvas_.landmark_uv, mask.curve[std::min<std::size_t>(1, last)]);
    const Vector2d inner_right = get(canvas_.landmark_uv, mask.curve[last - std::min<std::size_t>(1, last)]);
    const double middle = 0.5 * (inner_left.x() + inner_right.x());
    const double half = 0.5 * std::abs(inner_right.x() - inner_left.x());
    const double beyond = std::max(0.0, std::abs(uv.x() - middle) - mask.straight * half);
    const double line = a.y() + t * (b.y() - a.y());
    return smooth_step((line - uv.y()) / (mask.blend_uv + mask.blend_beyond * beyond));
  }

  template <typename Body>
  void over_nodes(const Body& body) {
    parallel_for(values_.size(), 8192, [&](std::size_t begin, std::size_t end) {
      for (std::size_t node = begin; node < end; ++node) body(node);
    });
  }

  const UvCanvas& canvas_;
  std::vector<Vector3d>& values_;
};

}  // namespace

double falloff(double radius, double plateau) {
  if (radius <= plateau) return 1;
  if (radius >= 1) return 0;
  const double t = (radius - plateau) / (1 - plateau), rest = 1 - t * t;
  return rest * rest;
}

std::vector<Vector3d> draw_muscle(const ControlMesh& generic_head, const UvCanvas& canvas,
                                  const MuscleFile& muscle) {
  const bool is_mask = muscle.type == FieldType::kRotate;
  std::vector<Vector3d> values(canvas.positions.size(),
                               is_mask ? Vector3d::UnitX().eval() : Vector3d::Zero().eval());
  Painter painter(canvas, values);
  for (const MusclePull& pull : muscle.pulls) painter.pull(pull);
  if (muscle.lids) painter.close(*muscle.lids);
  for (const MuscleMask& mask : muscle.masks) painter.mask(generic_head, mask);
  return values;
}

}  // namespace phiz
