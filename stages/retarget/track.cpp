#include "stages/retarget/track.h"

#include <algorithm>
#include <cmath>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "stages/geometry/surface_index.h"
#include "stages/retarget/bounded_solve.h"

namespace phiz {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kStep = 0.02;        ///< of central differences in a control
constexpr std::size_t kFewest = 500;  ///< matches that make a frame

/// Triangles of the level but for those in a control triangle that scans badly or moves with the body.
std::vector<Eigen::Vector3i> tracked_triangles(const ControlMesh& head, const NeutralMaker& maker) {
  const auto& regions = head.annotations.regions;
  std::vector<int> use(head.positions.size(), 1);
  for (const char* name : {"eyes", "nostrils", "inner_mouth", "scalp", "neck"}) {
    if (!regions.contains(name))
      throw InvalidInput("the generic head has no region '" + std::string(name) + "'");
    for (const int v : regions.at(name)) use[v] = 0;
  }
  std::vector<Eigen::Vector3i> triangles;
  const std::vector<Eigen::Vector3i>& all = maker.hierarchy().triangles(maker.level());
  for (std::size_t t = 0; t < all.size(); ++t) {
    const Eigen::Vector3i& control = head.triangles[t >> (2 * maker.level())];
    if (use[control[0]] + use[control[1]] + use[control[2]] == 3) triangles.push_back(all[t]);
  }
  return triangles;
}

struct Match {
  int triangle = 0;
  Vector3d weights, normal, point;  ///< normal of the posed triangle, point in the head frame
  double distance = 0;              ///< along the normal, from surface to point
};

double square(double x) {
  return x * x;
}

double tukey(double residual, double scale) {
  const double r = residual / scale;
  if (std::abs(r) >= 1) return 0;
  return (1 - r * r) * (1 - r * r);
}

}  // namespace

struct Tracker::Impl {
  TrackOptions options;
  Deformation rig;
  NeutralSurface neutral;
  std::unique_ptr<CompiledCascade> cascade;
  std::vector<Eigen::Vector3i> triangles;  ///< of the face, vertices renumbered
  std::vector<int> vertices;               ///< of the neutral surface, for each renumbered one
  std::vector<int> controls;               ///< those that move anything
  Eigen::VectorXd limits;                  ///< of these controls
  TrackedFrame state;

  std::vector<float> spread(const Eigen::VectorXd& q) const {
    std::vector<float> all(rig.controls.size(), 0.0f);
    for (std::size_t k = 0; k < controls.size(); ++k)
      all[controls[k]] = static_cast<float>(q[static_cast<Eigen::Index>(k)]);
    return all;
  }

  /// Positions of the face's vertices; parameters are not cut, so that slopes are there at the bounds.
  std::vector<Vector3f> pose(const Eigen::VectorXd& q) const {
    std::vector<double> sums(rig.parameters.size(), 0.0);
    for (std::size_t k = 0; k < controls.size(); ++k) {
      for (const auto& [parameter, weight] : terms[k])
        sums[parameter] += weight * q[static_cast<Eigen::Index>(k)];
    }
    const std::vector<float> parameters(sums.begin(), sums.end());
    std::vector<Vector3f> positions(cascade->point_count()), face;
    cascade->evaluate(parameters, positions);
    face.reserve(vertices.size());
    for (const int v : vertices) face.push_back(positions[v]);
    return face;
  }

  std::vector<std::vector<std::pair<std::size_t, double>>> terms;  ///< parameters of each of `controls`

  std::vector<std::vector<Vector3f>> slopes(const Eigen::VectorXd& q) const {
    std::vector<std::vector<Vector3f>> slope(controls.size());
    parallel_for(controls.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        Eigen::VectorXd more = q, less = q;
        more[static_cast<Eigen::Index>(k)] += kStep;
        less[static_cast<Eigen::Index>(k)] -= kStep;
        slope[k] = pose(more);
        const std::vector<Vector3f> below = pose(less);
        for (std::size_t v = 0; v < below.size(); ++v)
          slope[k][v] = (slope[k][v] - below[v]) / static_cast<float>(2 * kStep);
      }
    });
    return slope;
  }

  std::vector<Match> match(const std::vector<Vector3f>& face, std::span<const Vector3f> points,
                           double reach) const {
    const SurfaceIndex index(face, triangles);
    const Isometry3d head_from_scan = state.scan_from_head.inverse();
    std::vector<Vector3f> queries;
    for (const Vector3f& p : points) queries.push_back((head_from_scan * p.cast<double>()).cast<float>());
    const std::vector<SurfaceHit> hits = index.find_nearest(queries, reach);
    std::vector<Match> matches;
    for (std::size_t i = 0; i < hits.size(); ++i) {
      const SurfaceHit& hit = hits[i];
      if (hit.triangle_idx < 0 || hit.weights.minCoeff() <= 0) continue;  // rims match what lies beyond them
      const Eigen::Vector3i& corners = triangles[hit.triangle_idx];
      const Vector3d a = face[corners[0]].cast<double>(), b = face[corners[1]].cast<double>(),
                     c = face[corners[2]].cast<double>(), normal = (b - a).cross(c - a);
      if (!(normal.norm() > 1e-9)) continue;
      const Vector3d point = queries[i].cast<double>(), unit = normal.normalized();
      matches.push_back({hit.triangle_idx, hit.weights, unit, point, unit.dot(point - hit.position)});
    }
    return matches;
  }

  /// How far the surface comes towards a matched point for each unknown.
  template <typename Column>
  void fill_row(const Match& m, const std::vector<std::vector<Vector3f>>& slope, Column row) const {
    const Eigen::Vector3i& corners = triangles[m.triangle];
    const auto n = static_cast<Eigen::Index>(controls.size());
    for (Eigen::Index k = 0; k < n; ++k) {
      Vector3d way = Vector3d::Zero();
      for (int c = 0; c < 3; ++c) way += m.weights[c] * slope[k][corners[c]].cast<double>();
      row[k] = m.normal.dot(way);
    }
    row.template segment<3>(n) = m.point.cross(m.normal);
    row.template tail<3>() = m.normal;
  }

  /// One Gauss-Newton step.
  void step(std::span<const Vector3f> points, double reach, const Eigen::VectorXd& last, Eigen::VectorXd& q) {
    const std::vector<Vector3f> face = pose(q);
    const std::vector<Match> matches = match(face, points, reach);
    if (matches.size() < kFewest)
      throw InvalidInput("only " + std::to_string(matches.size()) + " points of the scan lie near the face");
    std::vector<double> sizes;
    for (const Match& m : matches) sizes.push_back(std::abs(m.distance));
    std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2),
                     sizes.end());
    const double noise = std::max(options.least_noise_mm, 1.4826 * sizes[sizes.size() / 2]);
    const std::vector<std::vector<Vector3f>> slope = slopes(q);
    const auto n = static_cast<Eigen::Index>(controls.size());
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(n + 6, static_cast<Eigen::Index>(matches.size()));
    Eigen::VectorXd rest = Eigen::VectorXd::Zero(rows.cols());
    double squares = 0, weights = 0;
    for (Eigen::Index i = 0; i < rows.cols(); ++i) {
      const Match& m = matches[static_cast<std::size_t>(i)];
      const double weight = tukey(m.distance, 4.685 * noise);
      if (weight == 0) continue;
      fill_row(m, slope, rows.col(i));
      rows.col(i) *= std::sqrt(weight);
      rest[i] = std::sqrt(weight) * m.distance;
      squares += weight * m.distance * m.distance;
      weights += weight;
    }
    Eigen::MatrixXd normal = rows * rows.transpose();
    Eigen::VectorXd right = rows * rest;
    for (Eigen::Index k = 0; k < n; ++k) {
      const double still = square(noise / options.neutral_sigma), keep = square(noise / options.last_sigma);
      normal(k, k) += still + keep;
      right[k] += -still * q[k] + keep * (last[k] - q[k]);
    }
    Eigen::VectorXd low = Eigen::VectorXd::Constant(n + 6, -1e3), high = -low;
    low.head(n) = -q;
    high.head(n) = limits - q;
    const Eigen::VectorXd way = solve_bounded(normal, right, low, high);
    q = (q + way.head(n)).cwiseMax(0).cwiseMin(limits);
    const Vector3d turn = way.segment<3>(n);
    Isometry3d move = Isometry3d::Identity();
    if (turn.norm() > 0) move.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    move.translation() = way.tail<3>();
    state.scan_from_head = state.scan_from_head * move;
    state.residual_mm = std::sqrt(squares / std::max(weights, 1e-9));
    state.matches = static_cast<int>(matches.size());
  }
};

Tracker::Tracker(const Deformation& rig, const ControlMesh& generic_head, const NeutralMaker& maker,
                 NeutralSurface neutral, const TrackOptions& options)
    : impl_(std::make_unique<Impl>()) {
  impl_->options = options;
  impl_->neutral = std::move(neutral);
  impl_->cascade =
      std::make_unique<CompiledCascade>(rig, sample_fields(rig, impl_->neutral.uv), impl_->neutral);
  impl_->rig.parameters = rig.parameters;
  impl_->rig.controls = rig.controls;
  std::vector<int> number(impl_->neutral.positions.size(), -1);
  for (Eigen::Vector3i triangle : tracked_triangles(generic_head, maker)) {
    for (int c = 0; c < 3; ++c) {
      if (number[triangle[c]] < 0) {
        number[triangle[c]] = static_cast<int>(impl_->vertices.size());
        impl_->vertices.push_back(triangle[c]);
      }
      triangle[c] = number[triangle[c]];
    }
    impl_->triangles.push_back(triangle);
  }
  std::map<std::string, std::size_t> index;
  for (const DeformationParameter& parameter : rig.parameters) index.emplace(parameter.name, index.size());
  std::vector<double> limits;
  for (std::size_t c = 0; c < rig.controls.size(); ++c) {
    if (rig.controls[c].terms.empty()) continue;
    impl_->controls.push_back(static_cast<int>(c));
    auto& terms = impl_->terms.emplace_back();
    double limit = 1e3;
    for (const auto& [name, weight] : rig.controls[c].terms) {
      terms.emplace_back(index.at(name), weight);
      if (weight > 0) limit = std::min(limit, rig.parameters[index.at(name)].maximum / weight);
    }
    limits.push_back(limit == 1e3 ? 1 : limit);
  }
  impl_->limits = Eigen::Map<Eigen::VectorXd>(limits.data(), static_cast<Eigen::Index>(limits.size()));
  impl_->state.controls.assign(rig.controls.size(), 0.0f);
}

Tracker::~Tracker() = default;

TrackedFrame Tracker::track(std::span<const Vector3f> points) {
  Impl& impl = *impl_;
  std::vector<Vector3f> drawn;
  const std::size_t stride =
      std::max<std::size_t>(1, points.size() / static_cast<std::size_t>(impl.options.points));
  for (std::size_t i = 0; i < points.size(); i += stride) {
    if (points[i].allFinite()) drawn.push_back(points[i]);
  }
  Eigen::VectorXd q(static_cast<Eigen::Index>(impl.controls.size()));
  for (std::size_t k = 0; k < impl.controls.size(); ++k)
    q[static_cast<Eigen::Index>(k)] = impl.state.controls[impl.controls[k]];
  const Eigen::VectorXd last = q;
  const int rounds = std::max(1, impl.options.rounds);
  for (int round = 0; round < rounds; ++round) {
    const double share = rounds == 1 ? 1 : static_cast<double>(round) / (rounds - 1);
    impl.step(drawn,
              impl.options.first_reach_mm *
                  std::pow(impl.options.last_reach_mm / impl.options.first_reach_mm, share),
              last, q);
  }
  impl.state.controls = impl.spread(q);
  return impl.state;
}

void Tracker::resume(const TrackedFrame& last) {
  if (last.controls.size() != impl_->state.controls.size())
    throw InvalidInput("a tracked frame of another rig");
  impl_->state = last;
}

}  // namespace phiz
