#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "stages/fit/deformation_system.h"
#include "stages/fit/eyelids.h"
#include "stages/fit/fit.h"
#include "stages/fit/folds.h"
#include "stages/geometry/annotations.h"
#include "stages/geometry/error.h"
#include "stages/geometry/half_edge.h"
#include "stages/geometry/normals.h"
#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

using Positions = DeformationSystem::Positions;

Positions to_matrix(const ControlPositions& positions) {
  Positions x(positions.size(), 3);
  for (std::size_t i = 0; i < positions.size(); ++i) x.row(i) = positions[i].transpose();
  return x;
}

std::vector<Eigen::Vector3d> to_vector(const Positions& x) {
  std::vector<Eigen::Vector3d> positions(x.rows());
  for (Eigen::Index i = 0; i < x.rows(); ++i) positions[i] = x.row(i).transpose();
  return positions;
}

struct RoundSettings {
  double smooth, normal_weight_mm, reach_mm, neck_weight;
  int level;
  bool soft;  ///< bending counts from where the round began, not from the start of the fit
};

RoundSettings settings_of(const GlobalFitOptions& o, int round) {
  if (round >= o.rounds)
    return {o.soft_weight, o.normal_weight_mm_last, o.reach_mm_last, 50 * o.neck_weight, 2, true};
  const double t = o.rounds > 1 ? double(round) / (o.rounds - 1) : 1.0;
  const auto between = [t](double first, double last) { return first * std::pow(last / first, t); };
  return {between(o.smooth_weight_first, o.smooth_weight_last),
          between(o.normal_weight_mm_first, o.normal_weight_mm_last),
          between(o.reach_mm_first, o.reach_mm_last),
          o.neck_weight,
          1,
          false};
}

constexpr double kUnfoldWeight = 10.0;  ///< lambda at folded places
constexpr double kSoftHold = 5.0;       ///< how much harder soft rounds hold samples against sliding
constexpr double kEyesInFrontMm = 0.4;  ///< scan so far in front of open eyes may be lids
constexpr double kShutGain = 0.93;      ///< misfit of shut eyes against open ones that decides
constexpr double kUnmeasuredMm = 1.0;   ///< what surface without scan counts in that misfit

class GlobalFit {
 public:
  GlobalFit(const ScanSurface& scan, const ControlMesh& head, const SubdivisionHierarchy& hierarchy,
            const ControlPositions& start, const GlobalFitOptions& options)
      : scan_(scan),
        head_(head),
        hierarchy_(hierarchy),
        options_(options),
        laplacian_(normalised_laplacian(head.triangles, start)),
        lids_(head),
        start_(to_matrix(start)),
        rest_(start_),
        rest_bend_(laplacian_ * rest_) {
    for (int level : {1, 2}) {
      samples_[level - 1] = compose_stencils(hierarchy, level);
      measurable_[level - 1] = find_measurable(samples_[level - 1]);
    }
    const HalfEdgeMesh mesh(head.triangles, static_cast<int>(head.positions.size()));
    face_edges_ = find_face_edges();
    hidden_ = find_hidden(head);
    for (const auto& loop : mesh.border_loops()) border_.insert(border_.end(), loop.begin(), loop.end());
    systems_[0] = std::make_unique<DeformationSystem>(samples_[0], laplacian_);
    systems_[1] = std::make_unique<DeformationSystem>(samples_[1], laplacian_);
  }

  /// One linearisation and solve. Returns the energy before the step under the new matches.
  double step(Positions& x, const Positions& round_start, const RoundSettings& s) {
    DeformationSystem& system = *systems_[s.level - 1];
    match(x, s, system);
    add_smoothness(x, round_start, s, system);
    add_constraints(round_start, s, system);
    const double energy = system.energy(x);
    system.solve(x, 1e-2, 40);
    return energy;
  }

  bool has_eyes() const { return lids_.eye_count() > 0; }

  /// Whether the eyes of the rest shape are shut.
  void set_eyes_shut(bool shut) {
    rest_ = start_;
    if (shut) shut_eyes(rest_);
    rest_bend_ = laplacian_ * rest_;
  }
  void shut_eyes(Positions& x) const {
    for (int eye = 0; eye < lids_.eye_count(); ++eye) lids_.shut(eye, x);
  }

  /// Whether the scan stands in front of open eyes as lids would.
  bool eyes_are_covered(const Positions& x) const {
    double sum = 0, count = 0;
    for (int eye = 0; eye < lids_.eye_count(); ++eye)
      for (const double offset_mm : measure_front(x, lids_.inside(eye)))
        if (std::isfinite(offset_mm)) sum += offset_mm, ++count;
    return count > 0 && sum > kEyesInFrontMm * count;
  }

  /// Mean distance in mm between the scan and the part of eyes and lids that faces forward, hidden or not:
  /// shut eyes pay for the eye behind their lids.
  double measure_eyes(const Positions& x) const {
    double sum = 0, count = 0;
    for (int eye = 0; eye < lids_.eye_count(); ++eye)
      for (const double offset_mm : measure_front(x, lids_.moved(eye)))
        sum += std::isfinite(offset_mm) ? std::abs(offset_mm) : kUnmeasuredMm, ++count;
    return count > 0 ? sum / count : 0.0;
  }

  /// Lays flat what is still folded.
  void lay_flat(Positions& x) const { lay_folds_flat({hierarchy_, samples_, laplacian_, rest_}, x); }

  /// Matches `x` as a round would: what the two below tell.
  void measure(const Positions& x, const RoundSettings& s) { match(x, s, *systems_[s.level - 1]); }
  double mean_distance_mm() const { return mean_distance_mm_; }
  double matched_share() const { return matched_share_; }

 private:
  /// Offsets of the scan along the normals of level 2 where that hangs on `vertices` and looks forward; not a
  /// number where nothing is found.
  std::vector<double> measure_front(const Positions& x, const std::vector<int>& vertices) const {
    constexpr double kShare = 0.95, kForward = 0.3;
    constexpr float kBandwidthMm = 0.8f, kReachMm = 3.0f;
    std::vector<char> wanted(x.rows(), 0);
    for (const int v : vertices) wanted[v] = 1;
    const auto positions = to_vector(samples_[1] * x);
    const auto normals = compute_vertex_normals(positions, hierarchy_.triangles(2));
    std::vector<double> offsets;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      double share = 0;
      for (StencilMatrix::InnerIterator it(samples_[1], i); it; ++it) share += wanted[it.col()] * it.value();
      if (share < kShare || normals[i].z() < kForward) continue;
      const auto found =
          scan_.measure(positions[i].cast<float>(), normals[i].cast<float>(), kBandwidthMm, kReachMm);
      offsets.push_back(found.confidence > 0 ? found.offset_mm : std::numeric_limits<double>::quiet_NaN());
    }
    return offsets;
  }

  /// Edges inside the region `face`, each once.
  std::vector<std::pair<int, int>> find_face_edges() const {
    const auto face = head_.annotations.regions.find("face");
    if (face == head_.annotations.regions.end()) return {};
    std::vector<char> inside(head_.positions.size(), 0);
    for (const int v : face->second) inside[v] = 1;
    std::vector<std::pair<int, int>> edges;
    for (const Eigen::Vector3i& t : head_.triangles)
      for (int i = 0; i < 3; ++i)
        if (inside[t[i]] && inside[t[(i + 1) % 3]]) edges.emplace_back(std::minmax(t[i], t[(i + 1) % 3]));
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    return edges;
  }

  /// Samples that hang on constrained vertices (inner lips) are not measured.
  std::vector<char> find_measurable(const StencilMatrix& samples) const {
    std::vector<char> constrained(head_.positions.size(), 0);
    for (const int v : head_.annotations.constrained_vertices) constrained[v] = 1;
    std::vector<char> measurable(samples.rows(), 1);
    for (Eigen::Index r = 0; r < samples.rows(); ++r) {
      double share = 0;
      for (StencilMatrix::InnerIterator it(samples, r); it; ++it) share += constrained[it.col()] * it.value();
      measurable[r] = share < 0.3;
    }
    return measurable;
  }

  void match(const Positions& x, const RoundSettings& s, DeformationSystem& system) {
    const Positions at = samples_[s.level - 1] * x;
    const auto positions = to_vector(at);
    const auto normals = compute_vertex_normals(positions, hierarchy_.triangles(s.level));
    const auto& measurable = measurable_[s.level - 1];
    system.sample_terms.assign(positions.size(), {});
    // A level has four times the samples of the one before: the weight of the data as a whole stays.
    const double unit = s.level == 1 ? 1.0 : 0.25;
    std::vector<double> distances(positions.size(), -1);
    parallel_for(positions.size(), 256, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        if (!measurable[i]) continue;
        const auto match =
            scan_.find_match(positions[i].cast<float>(), normals[i].cast<float>(),
                             static_cast<float>(s.normal_weight_mm), static_cast<float>(s.reach_mm));
        if (match.surfel_idx < 0) continue;
        const Surfel& surfel = scan_.surfels()[match.surfel_idx];
        if (surfel.border > 0.8f && match.distance > 1.5f) continue;
        SampleTerm& t = system.sample_terms[i];
        t.target = t.slide_target = surfel.position.cast<double>();
        t.normal = (surfel.normal.cast<double>() + normals[i]).normalized();
        const double along = t.normal.dot(positions[i] - t.target);
        const double relative = along / (0.35 * s.reach_mm);
        const double robust = 1.0 / std::pow(1.0 + relative * relative, 2);
        const double alike = std::max(0.0, double(surfel.normal.dot(normals[i].cast<float>())));
        t.weight = unit * robust * alike * alike * (0.1 + surfel.confidence);
        t.point_weight = options_.slide_weight * t.weight * (1 - surfel.border);
        if (s.soft) {  // features are in place: hold them there instead of pulling
          t.slide_target = positions[i] - along * t.normal;
          t.point_weight *= kSoftHold;
        }
        distances[i] = std::abs(along);
      }
    });
    double sum = 0, measured = 0;
    int matched = 0;
    for (std::size_t i = 0; i < distances.size(); ++i) {
      measured += measurable[i];
      if (distances[i] >= 0) sum += distances[i], ++matched;
    }
    mean_distance_mm_ = matched ? sum / matched : 0;
    matched_share_ = measured > 0 ? matched / measured : 0;
  }

  /// E_smooth: the bending of the start (soft rounds: of the round's start) is kept.
  void add_smoothness(const Positions& x, const Positions& round_start, const RoundSettings& s,
                      DeformationSystem& system) const {
    system.smooth_weights = Eigen::VectorXd::Constant(round_start.rows(), s.smooth);
    for (const int v : head_.annotations.constrained_vertices)
      system.smooth_weights[v] += options_.constraint_weight;
    const std::vector<Eigen::Vector3i>& triangles = head_.triangles;
    std::vector<char> folded(head_.positions.size(), 0);
    for (const int t : find_folded({hierarchy_, {}, laplacian_, rest_}, x))
      for (const int v : triangles[t]) folded[v] = 1;
    for (std::size_t v = 0; v < folded.size(); ++v) system.smooth_weights[v] += kUnfoldWeight * folded[v];
    if (s.soft) {
      for (std::size_t v = 0; v < hidden_.size(); ++v)
        system.smooth_weights[v] += options_.hidden_weight * hidden_[v];
      system.delta = laplacian_ * round_start;
    } else {
      system.delta = rest_bend_;
    }
  }

  void add_constraints(const Positions& round_start, const RoundSettings& s,
                       DeformationSystem& system) const {
    const Positions& shape = s.soft ? round_start : rest_;
    system.pair_terms.clear();
    for (const auto& [a, b] : head_.annotations.binding_edges)
      system.pair_terms.push_back({a, b, (shape.row(a) - shape.row(b)).transpose(), options_.binding_weight});
    const double stretch_weight = options_.stretch_weight * s.smooth;
    for (const auto& [a, b] : face_edges_)
      if (!s.soft)
        system.pair_terms.push_back({a, b, (shape.row(a) - shape.row(b)).transpose(), stretch_weight});
    system.plane_terms.clear();
    if (!options_.neck) return;
    for (const int v : border_)
      system.plane_terms.push_back({v, options_.neck->normal, options_.neck->offset_mm, s.neck_weight});
  }

  const ScanSurface& scan_;
  const ControlMesh& head_;
  const SubdivisionHierarchy& hierarchy_;
  const GlobalFitOptions& options_;
  StencilMatrix laplacian_;
  Eyelids lids_;
  Positions start_, rest_, rest_bend_;
  std::vector<int> border_;
  std::vector<std::pair<int, int>> face_edges_;
  std::vector<char> hidden_;
  StencilMatrix samples_[2];
  std::vector<char> measurable_[2];
  std::unique_ptr<DeformationSystem> systems_[2];
  double mean_distance_mm_ = 0, matched_share_ = 0;
};

double area_of(const ControlPositions& p, const std::vector<Eigen::Vector3i>& triangles) {
  double area = 0;
  for (const auto& t : triangles) area += 0.5 * (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).norm();
  return area;
}

/// Misfit of eyes and lids where soft rounds from x end, with the eyes of the fit as they are.
double try_soft_rounds(GlobalFit& fit, Positions x, const GlobalFitOptions& options) {
  for (int round = 0; round < options.soft_rounds; ++round) {
    const Positions round_start = x;
    for (int i = 0; i < options.iterations_per_round; ++i)
      fit.step(x, round_start, settings_of(options, options.rounds + round));
  }
  return fit.measure_eyes(x);
}

/// Behind the stiff rounds: whether the scan's eyes are shut. The fit's eyes and x are so afterwards.
bool settle_eyes(GlobalFit& fit, Positions& x, const GlobalFitOptions& options) {
  bool shut = options.eyes == Eyes::kShut && fit.has_eyes();
  Positions with_shut = x;
  fit.shut_eyes(with_shut);
  if (options.eyes == Eyes::kAsTheScan && options.soft_rounds > 0 && fit.eyes_are_covered(x)) {
    const double open_misfit = try_soft_rounds(fit, x, options);
    fit.set_eyes_shut(true);
    shut = try_soft_rounds(fit, with_shut, options) < kShutGain * open_misfit;
  }
  fit.set_eyes_shut(shut);
  if (shut) x = with_shut;
  return shut;
}

/// A fit that collapsed, blew up or found next to nothing to hold on to is no head.
void check_result(const GlobalFit& fit, const GlobalFitState& state, const ControlPositions& positions,
                  const ControlPositions& start, const std::vector<Eigen::Vector3i>& triangles) {
  const double grown = area_of(positions, triangles) / area_of(start, triangles);
  if (!(grown > 0.5 && grown < 2.0))
    throw FitRejected("the head " + std::string(grown > 1 ? "blew up" : "collapsed") + " in the global fit");
  if (state.energies.empty() || fit.matched_share() >= 0.2) return;
  throw FitRejected("only " + std::to_string(static_cast<int>(100 * fit.matched_share())) +
                    " % of the head's surface found the scan");
}

}  // namespace

GlobalFitResult fit_global(const ScanSurface& scan, const ControlMesh& generic_head,
                           const SubdivisionHierarchy& hierarchy, const ControlPositions& start,
                           const GlobalFitOptions& options, const GlobalFitState* resume,
                           const GlobalFitProgress& progress) {
  CONTRACT(start.size() == generic_head.positions.size() && hierarchy.level_count() >= 2);
  GlobalFit fit(scan, generic_head, hierarchy, start, options);
  GlobalFitState state;
  if (resume) {
    state = *resume;
  } else {
    state.positions = state.round_start = start;
  }
  fit.set_eyes_shut(state.eyes_shut);
  Positions x = to_matrix(state.positions);
  for (const int rounds = options.rounds + options.soft_rounds; state.round < rounds;) {
    const RoundSettings settings = settings_of(options, state.round);
    const double energy = fit.step(x, to_matrix(state.round_start), settings);
    const bool settled = state.iteration > 0 && std::abs(state.energies.back() - energy) <
                                                    options.tolerance * std::abs(state.energies.back());
    state.energies.push_back(energy);
    state.positions = to_vector(x);
    if (settled || ++state.iteration >= options.iterations_per_round) {
      ++state.round;
      state.iteration = 0;
      if (state.round == options.rounds) {
        state.eyes_shut = settle_eyes(fit, x, options);
        state.positions = to_vector(x);
      }
      state.round_start = state.positions;
    }
    if (progress && !progress(state)) break;
  }
  if (state.round >= options.rounds + options.soft_rounds && x.allFinite()) fit.lay_flat(x);
  // At the end and not in the last step: a fit resumed behind its last step has made none.
  fit.measure(x, settings_of(options, std::min(state.round, options.rounds + options.soft_rounds - 1)));
  check_result(fit, state, to_vector(x), start, generic_head.triangles);
  if (!x.allFinite()) throw NumericalFailure("the global fit diverged");
  return {to_vector(x), state.energies, fit.mean_distance_mm(), fit.matched_share(), state.eyes_shut};
}

}  // namespace phiz
