#include "stages/animate/skin_state.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "stages/animate/lanes.h"

namespace phiz {
namespace {

constexpr int kUnturnPasses = 8, kMendPasses = 6;
constexpr float kUnturnShare = 0.2f;        ///< of a turned face's deformation that stays
constexpr float kLongestGuess = 1.0f / 60;  ///< s
constexpr float kRimStiffness = 1.5f;       ///< where lips or lids are through each other, in springs

PHIZ_LANES_INLINE Float4 load(const Point4& p) {
  return load_at(&p, 0);
}
PHIZ_LANES_INLINE void add(Float4 value, Point4& to) {
  store4(load(to) + value, to);
}

float dot(const Point4& a, const Point4& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
Eigen::Vector3d wide(const Point4& p) {
  return {p.x, p.y, p.z};
}

}  // namespace

void Skin::State::reset() {
  std::fill(moved.begin(), moved.end(), Point4{});
  std::fill(velocity.begin(), velocity.end(), Point4{});
  std::fill(force_.begin(), force_.end(), Point4{});
  std::fill(jaw_moved_.begin(), jaw_moved_.end(), Point4{});
  jaw_turn_.setIdentity();
  publish();
}

void Skin::State::publish() {
  for (std::size_t v = 0; v < moved.size(); ++v) {
    store4(load(rest[v]) + load(moved[v]), shape_[v]);
    positions[v] = {shape_[v].x, shape_[v].y, shape_[v].z};
  }
}

/// Where the jaw carries its vertices.
void Skin::State::apply_jaw(std::span<const float> activations) {
  double turn = 0, twist = 0;
  Eigen::Vector3d slide = Eigen::Vector3d::Zero();
  for (std::size_t m = 0; m < layout->jaw_motions().size(); ++m) {
    const JawMotion& motion = layout->jaw_motions()[m];
    const double amount = std::clamp(activations[m], 0.0f, layout->maximum(m));
    turn += amount * motion.turn_deg, twist += amount * motion.twist_deg, slide += amount * motion.slide_mm;
  }
  const double radians = std::numbers::pi / 180;
  const Eigen::Vector3d axis = (condyle_left - condyle_right).normalized();
  const Eigen::Vector3d middle = 0.5 * (condyle_left + condyle_right);
  const Eigen::Matrix3d rotation =
      (Eigen::AngleAxisd(radians * twist, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(radians * turn, axis))
          .toRotationMatrix();
  jaw_turn_ = rotation.cast<float>();
  const bool is_still = turn == 0 && twist == 0 && slide.isZero();
  for (const JawTie& tie : jaw_ties) {
    const Eigen::Vector3d place = wide(rest[tie.vertex]);
    const Eigen::Vector3d way = middle + rotation * (place - middle) + slide - place;
    Point4& to = jaw_moved_[tie.vertex];
    to = is_still ? Point4{}
                  : Point4{static_cast<float>(way.x()), static_cast<float>(way.y()),
                           static_cast<float>(way.z()), 0};
    add(load(to) * tie.stiffness, force_[tie.vertex]);
  }
}

void Skin::State::set_activations(std::span<const float> activations) {
  std::fill(force_.begin(), force_.end(), Point4{});
  apply_jaw(activations);
  const std::size_t first = layout->jaw_motions().size();
  for (std::size_t m = 0; m < muscles.size(); ++m) {
    const float amount = std::clamp(activations[first + m], 0.0f, layout->maximum(first + m));
    if (!(amount > 0)) continue;
    const Muscle& muscle = muscles[m];
    for (const Pull& pull : muscle.pulls) {
      Eigen::Vector3f force(pull.force.x, pull.force.y, pull.force.z);
      if (muscle.is_on_jaw) force = jaw_turn_ * force;
      add(Float4{force.x(), force.y(), force.z(), 0} * amount, force_[pull.vertex]);
    }
    for (const int v : muscle.retreating)
      add(load(muscle.retreat) * (amount * skull_stiffness[v]), force_[v]);
  }
}

/// gradient = inertia (moved - goal) + linear part of moved + damping (moved - start) - forces.
void Skin::State::add_linear(float inertia_scale, float damping_scale) {
  for (std::size_t v = 0; v < moved.size(); ++v)
    store4(load(moved[v]) + (load(moved[v]) - load(start_[v])) * damping_scale, scratch_[v]);
  for (std::size_t v = 0; v < moved.size(); ++v) {
    Float4 sum = (load(moved[v]) - load(goal_[v])) * (masses[v] * inertia_scale) - load(force_[v]);
    for (int e = linear_offsets[v]; e < linear_offsets[v + 1]; ++e)
      sum += load(scratch_[linear_columns[e]]) * linear_values[e];
    store4(sum, gradient_[v]);
    store4(load(rest[v]) + load(moved[v]), shape_[v]);
  }
}

void Skin::State::add_springs(float damping_scale) {
  const auto strain = static_cast<float>(options.phase_strain),
             ratio = static_cast<float>(options.stiff_ratio);
  for (const Spring& spring : springs) {
    const Float4 way = load(shape_[spring.a]) - load(shape_[spring.b]);
    const float length = std::sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
    const float change = length - spring.length, soft = strain * spring.length;
    float tension = change;
    if (change > soft) tension = soft + ratio * (change - soft);
    if (change < -soft) tension = -soft + ratio * (change + soft);
    Float4 pull = way * (spring.stiffness * tension / std::max(length, 1e-6f));
    if (damping_scale > 0)
      pull += ((load(moved[spring.a]) - load(moved[spring.b])) -
               (load(start_[spring.a]) - load(start_[spring.b]))) *
              (damping_scale * spring.stiffness);
    add(pull, gradient_[spring.a]);
    add(-pull, gradient_[spring.b]);
  }
}

/// Bone stops firm skin, volumes resist, lips and lids part.
void Skin::State::add_contacts() {
  const auto flesh = static_cast<float>(options.flesh_mm);
  for (const Stop& stop : stops) {
    Point4 way;
    store4(load(moved[stop.vertex]) - load(jaw_moved_[stop.vertex]) * stop.jaw_share, way);
    const float depth = dot(way, stop.normal) + flesh;
    if (depth < 0) add(load(stop.normal) * (depth * stop.stiffness), gradient_[stop.vertex]);
  }
  for (const Volume& volume : volumes) {
    float change = 0;
    for (std::size_t v = 0; v < moved.size(); ++v) change += dot(moved[v], volume.gradient[v]);
    for (std::size_t v = 0; v < moved.size(); ++v)
      add(load(volume.gradient[v]) * (change * volume.stiffness), gradient_[v]);
  }
  if (rims) rims->add_gradient(shape_, kRimStiffness, gradient_);
}

/// moved -= scale * A^-1 gradient, where A bounds the curvature: the energy never grows.
void Skin::State::improve(const Factor& factor, float scale) {
  factor.solver->solve(gradient_.data(), scratch_.data());
  const auto count = static_cast<Eigen::Index>(volumes.size());
  Eigen::Matrix<float, Eigen::Dynamic, 1, 0, 8, 1> changes(count), shares(count);
  for (Eigen::Index q = 0; q < count; ++q) {
    changes[q] = 0;
    for (std::size_t v = 0; v < moved.size(); ++v) changes[q] += dot(gradient_[v], volumes[q].gradient[v]);
  }
  for (Eigen::Index q = 0; q < count; ++q) {
    shares[q] = 0;
    for (Eigen::Index r = 0; r < count; ++r) shares[q] += factor.correction(q, r) * changes[r];
    for (std::size_t v = 0; v < moved.size(); ++v)
      add(load(factor.responses[q][v]) * -shares[q], gradient_[v]);
  }
  for (std::size_t v = 0; v < moved.size(); ++v) add(load(gradient_[v]) * -scale, moved[v]);
}

const Skin::State::Factor& Skin::State::find_factor(double seconds, float& scale) const {
  // The last factor is the one without inertia: relax() takes it.
  std::size_t k = 0;
  while (k + 2 < factors.size() && factors[k + 1].seconds <= seconds) ++k;
  const double share = std::min(seconds / factors[k].seconds, 1.0);
  scale = static_cast<float>(share * share);
  return factors[k];
}

void Skin::State::step(double seconds) {
  const double theta = 0.5 + 0.5 * std::clamp(options.dissipation, 0.0, 1.0), part = theta * seconds;
  const auto h = static_cast<float>(part), inertia = static_cast<float>(1 / (part * part));
  const auto damping = static_cast<float>(options.damping_s / part);
  float scale = 1;
  const Factor& factor = find_factor(part, scale);
  start_ = moved;
  // A long step's velocity is spent long before its end: no good place to begin from.
  const float begin = std::min(h, kLongestGuess);
  for (std::size_t v = 0; v < moved.size(); ++v) {
    const Point4 before = moved[v];
    store4(load(before) + load(velocity[v]) * h, goal_[v]);
    store4(load(before) + load(velocity[v]) * begin, moved[v]);
  }
  for (int round = 0; round < options.rounds; ++round) {
    add_linear(inertia, damping);
    add_springs(damping);
    if (options.is_tied) add_contacts();
    improve(factor, scale);
  }
  const auto beyond = static_cast<float>(1 / theta);
  for (std::size_t v = 0; v < moved.size(); ++v) {
    const Float4 way = load(moved[v]) - load(start_[v]);
    const Float4 before = load(velocity[v]);
    store4(before + (way / h - before) * beyond, velocity[v]);
    store4(load(start_[v]) + way * beyond, moved[v]);
  }
  publish();
  mend();
}

/// Faces that turned over are turned back, then lips and lids part: again, since each may undo the other.
void Skin::State::mend() {
  if (!rims) return;
  for (int pass = 0; pass < kMendPasses; ++pass) {
    const bool is_mended = unturn();
    rims->part(shape_);
    for (const int v : rims->vertices()) {
      const Float4 way = load(shape_[v]) - load(rest[v]), parted = way - load(moved[v]);
      // Where nothing was crossed only rounding is left, which must not wake what rests.
      if (std::abs(parted[0]) + std::abs(parted[1]) + std::abs(parted[2]) >= 1e-3f) store4(way, moved[v]);
    }
    publish();
    if (!is_mended) return;
  }
}

/// The corners of a face that turned by more than 90 degrees nearly go the same way: it moves as one. False
/// where there was none.
bool Skin::State::unturn() {
  bool is_any = false, is_more = true;
  for (int pass = 0; pass < kUnturnPasses && is_more; ++pass) {
    is_more = false;
    for (std::size_t t = 0; t < visible_triangles.size(); ++t) {
      const Eigen::Vector3i& corners = visible_triangles[t];
      const Float4 a = load(shape_[corners[0]]), ab = load(shape_[corners[1]]) - a,
                   ac = load(shape_[corners[2]]) - a;
      const Eigen::Vector3f normal(ab[1] * ac[2] - ab[2] * ac[1], ab[2] * ac[0] - ab[0] * ac[2],
                                   ab[0] * ac[1] - ab[1] * ac[0]);
      if (!(normal.dot(rest_normals[t]) < 0)) continue;
      is_any = is_more = true;
      const Float4 mean =
          (load(moved[corners[0]]) + load(moved[corners[1]]) + load(moved[corners[2]])) / 3.0f;
      for (const int v : corners) {
        store4(mean + (load(moved[v]) - mean) * kUnturnShare, moved[v]);
        store4(load(rest[v]) + load(moved[v]), shape_[v]);
      }
    }
  }
  return is_any;
}

void Skin::State::relax(int rounds) {
  start_ = moved;
  goal_ = moved;
  for (int round = 0; round < rounds; ++round) {
    add_linear(0, 0);
    add_springs(0);
    if (options.is_tied) add_contacts();
    improve(factors.back(), 1);
  }
  std::fill(velocity.begin(), velocity.end(), Point4{});
  publish();
  mend();
}

Skin::Figures Skin::State::measure() const {
  Figures figures;
  for (std::size_t v = 0; v < moved.size(); ++v) {
    const Eigen::Vector3d u = wide(moved[v]), speed = wide(velocity[v]), momentum = masses[v] * speed;
    figures.kinetic += 0.5 * momentum.dot(speed);
    figures.momentum += momentum;
    figures.angular_momentum += (wide(rest[v]) + u).cross(momentum);
    figures.farthest_mm = std::max(figures.farthest_mm, u.norm());
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int e = linear_offsets[v]; e < linear_offsets[v + 1]; ++e)
      sum += double{linear_values[e]} * wide(moved[linear_columns[e]]);
    figures.elastic += 0.5 * u.dot(sum);
  }
  for (const Spring& spring : springs) {
    const double length = (wide(shape_[spring.a]) - wide(shape_[spring.b])).norm();
    const double change = std::abs(length - spring.length), soft = options.phase_strain * spring.length;
    const double beyond = std::max(change - soft, 0.0);
    figures.elastic +=
        0.5 * spring.stiffness * (change * change + (options.stiff_ratio - 1) * beyond * beyond);
  }
  if (rims) figures.crossing_mm = rims->deepest(shape_);
  return figures;
}

}  // namespace phiz
