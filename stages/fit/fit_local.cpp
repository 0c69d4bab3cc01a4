#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <queue>

#include "stages/fit/fit.h"
#include "stages/geometry/annotations.h"
#include "stages/geometry/distance_lattice.h"
#include "stages/geometry/error.h"
#include "stages/geometry/half_edge.h"
#include "stages/geometry/normals.h"
#include "stages/geometry/parallel.h"
#include "stages/geometry/powell.h"

namespace phiz {
namespace {

/// Rotation vector, translation in mm and log scales about a centre.
struct FeatureTransform {
  Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero(), shift = Eigen::Vector3d::Zero();

  FeatureTransform(const Eigen::VectorXd& q, const Eigen::Vector3d& about)
      : centre(about), shift(q.segment<3>(3)) {
    const Eigen::Vector3d omega = q.head<3>();
    const double angle = omega.norm();
    const Eigen::Matrix3d turn = angle < 1e-12 ? Eigen::Matrix3d::Identity()
                                               : Eigen::AngleAxisd(angle, omega / angle).toRotationMatrix();
    linear = turn * q.segment<3>(6).array().exp().matrix().asDiagonal();
  }
  Eigen::Vector3d operator()(const Eigen::Vector3d& p) const {
    return linear * (p - centre) + centre + shift;
  }
  Eigen::Vector3d inverse(const Eigen::Vector3d& p) const {
    return linear.inverse() * (p - centre - shift) + centre;
  }
};

struct Feature {
  std::string name;
  std::vector<int> vertices;  ///< in the box
  std::vector<int> rim;       ///< of these, with a neighbour outside
};

std::vector<Feature> find_features(const ControlMesh& head) {
  const HalfEdgeMesh mesh(head.triangles, static_cast<int>(head.positions.size()));
  std::vector<Feature> features;
  for (const auto& [name, box] : head.annotations.boxes) {
    Feature feature{name, {}, {}};
    for (int v = 0; v < mesh.vertex_count(); ++v) {
      if (!box.contains(head.positions[v])) continue;
      feature.vertices.push_back(v);
      for (const int n : mesh.ring(v))
        if (!box.contains(head.positions[n])) {
          feature.rim.push_back(v);
          break;
        }
    }
    if (feature.vertices.size() >= 4) features.push_back(std::move(feature));
  }
  return features;
}

class FeatureFit {
 public:
  FeatureFit(const Feature& feature, const ScanSurface& scan, const std::vector<Eigen::Vector3d>& positions,
             const std::vector<Eigen::Vector3i>& triangles, const LocalFitOptions& options)
      : options_(options) {
    std::vector<char> inside(positions.size(), 0);
    for (const int v : feature.vertices) {
      inside[v] = 1;
      box_.extend(positions[v]);
    }
    centre_ = box_.center();
    for (const int v : feature.rim) rim_.push_back(positions[v]);
    std::vector<Eigen::Vector3f> dense;
    for (const auto& t : triangles)
      if (inside[t[0]] && inside[t[1]] && inside[t[2]])
        sample_triangle(positions[t[0]], positions[t[1]], positions[t[2]], dense);
    const std::size_t wanted = options.samples;
    for (std::size_t i = 0; i < std::min(wanted, dense.size()); ++i)
      samples_.push_back(dense[i * dense.size() / std::min(wanted, dense.size())].cast<double>());
    const Eigen::AlignedBox3d reach(box_.min().array() - options.reach_mm,
                                    box_.max().array() + options.reach_mm);
    const Eigen::AlignedBox3d near(box_.min().array() - 0.4 * options.reach_mm,
                                   box_.max().array() + 0.4 * options.reach_mm);
    std::vector<Eigen::Vector3f> around;
    for (const Surfel& s : scan.surfels()) {
      if (s.confidence < 0.15f || !reach.contains(s.position.cast<double>())) continue;
      around.push_back(s.position);
      if (near.contains(s.position.cast<double>())) scan_samples_.push_back(s.position.cast<double>());
    }
    if (around.size() < 60 || dense.empty()) return;
    const float margin = static_cast<float>(options.reach_mm);
    scan_lattice_ = std::make_unique<DistanceLattice>(around, margin, 72);
    model_lattice_ = std::make_unique<DistanceLattice>(dense, margin, 72);
    std::vector<Eigen::Vector3d> kept;
    for (std::size_t i = 0; i < std::min(wanted, scan_samples_.size()); ++i)
      kept.push_back(scan_samples_[i * scan_samples_.size() / std::min(wanted, scan_samples_.size())]);
    scan_samples_ = std::move(kept);
  }

  bool usable() const { return scan_lattice_ && !scan_samples_.empty() && !samples_.empty(); }
  const Eigen::Vector3d& centre() const { return centre_; }

  /// E_dist + E_stretch, both in mm^2: mean robust squared distances both ways, and what the rim moves.
  double energy(const Eigen::VectorXd& q) const {
    const FeatureTransform transform(q, centre_);
    double model_sum = 0, scan_sum = 0;
    for (const auto& p : samples_)
      model_sum += robust(scan_lattice_->at(transform(p).cast<float>()).distance);
    const Eigen::Matrix3d inverse = transform.linear.inverse();
    const Eigen::Vector3d offset = transform.centre + transform.shift;
    int counted = 0;
    for (const auto& s : scan_samples_) {
      const Eigen::Vector3d p = inverse * (s - offset) + centre_;
      if (!box_.contains(p)) continue;
      scan_sum += robust(model_lattice_->at(p.cast<float>()).distance);
      ++counted;
    }
    double stretch = 0;
    for (const auto& p : rim_) stretch += (transform(p) - p).squaredNorm();
    const double deform = q.tail<3>().squaredNorm() * 150 + q.head<3>().squaredNorm() * 100;
    return model_sum / samples_.size() + (counted ? scan_sum / counted : robust(1e3)) +
           options_.stretch_weight * (stretch / std::max<std::size_t>(1, rim_.size()) + deform);
  }

 private:
  static void sample_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                              std::vector<Eigen::Vector3f>& out) {
    const int n = std::max(1, static_cast<int>(std::ceil((b - a).cwiseAbs().maxCoeff() / 1.5)));
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n - i; ++j)
        out.push_back((a + (b - a) * (i + 1.0 / 3) / n + (c - a) * (j + 1.0 / 3) / n).cast<float>());
  }

  double robust(double distance) const {
    const double c2 = 0.09 * options_.reach_mm * options_.reach_mm, d2 = distance * distance;
    return d2 / (1 + d2 / c2);
  }

  const LocalFitOptions& options_;
  Eigen::AlignedBox3d box_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> samples_, rim_, scan_samples_;
  std::unique_ptr<DistanceLattice> scan_lattice_, model_lattice_;
};

/// Graph distance of every vertex to a feature, and the feature vertex it is nearest to (Dijkstra; ties to
/// the lower index).
void spread(const HalfEdgeMesh& mesh, const std::vector<Eigen::Vector3d>& positions, const Feature& feature,
            std::vector<double>& distance, std::vector<int>& nearest) {
  distance.assign(positions.size(), std::numeric_limits<double>::infinity());
  nearest.assign(positions.size(), -1);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (const int v : feature.vertices) {
    distance[v] = 0;
    nearest[v] = v;
    queue.push({0, v});
  }
  while (!queue.empty()) {
    const auto [d, v] = queue.top();
    queue.pop();
    if (d > distance[v]) continue;
    for (const int n : mesh.ring(v)) {
      const double through = d + (positions[n] - positions[v]).norm();
      if (through < distance[n]) {
        distance[n] = through;
        nearest[n] = nearest[v];
        queue.push({through, n});
      }
    }
  }
}

PowellResult minimise_feature(const FeatureFit& fit) {
  PowellOptions powell;
  powell.initial_steps.resize(9);
  powell.initial_steps << 0.06, 0.06, 0.06, 2, 2, 2, 0.06, 0.06, 0.06;
  powell.relative_tolerance = 2e-3;
  powell.max_evaluations = 1200;
  return minimise_powell([&](const Eigen::VectorXd& q) { return fit.energy(q); }, Eigen::VectorXd::Zero(9),
                         powell);
}

}  // namespace

LocalFitResult fit_local(const ScanSurface& scan, const ControlMesh& generic_head,
                         const ControlPositions& aligned, const LocalFitOptions& options) {
  CONTRACT(aligned.size() == generic_head.positions.size());
  require_annotations(generic_head);
  LocalFitResult result{aligned, {}};
  const auto features = find_features(generic_head);
  const HalfEdgeMesh mesh(generic_head.triangles, static_cast<int>(aligned.size()));
  result.boxes.resize(features.size());
  std::vector<std::optional<FeatureTransform>> transforms(features.size());
  parallel_for(features.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      LocalFitBox& box = result.boxes[f];
      box.name = features[f].name;
      const FeatureFit fit(features[f], scan, aligned, generic_head.triangles, options);
      if (!fit.usable()) continue;
      box.energy_before = fit.energy(Eigen::VectorXd::Zero(9));
      const PowellResult best = minimise_feature(fit);
      box.energy_after = best.value;
      box.evaluations = best.evaluations;
      box.applied = best.value < box.energy_before;
      if (box.applied) transforms[f].emplace(best.parameters, fit.centre());
    }
  });
  // Features and their surroundings: weights fall exponentially and are shared where features overlap.
  std::vector<Eigen::Vector3d> moved(aligned.size(), Eigen::Vector3d::Zero());
  std::vector<double> total(aligned.size(), 0.0), distance;
  std::vector<int> nearest;
  for (std::size_t f = 0; f < features.size(); ++f) {
    if (!transforms[f]) continue;
    spread(mesh, aligned, features[f], distance, nearest);
    for (std::size_t v = 0; v < aligned.size(); ++v) {
      if (nearest[v] < 0) continue;
      const double w = std::exp(-distance[v] / options.blend_mm);
      const Eigen::Vector3d& anchor = aligned[nearest[v]];
      moved[v] += w * w * ((*transforms[f])(anchor)-anchor);
      total[v] += w;
    }
  }
  for (std::size_t v = 0; v < aligned.size(); ++v)
    if (total[v] > 0) result.positions[v] += moved[v] / std::max(1.0, total[v]);
  return result;
}

}  // namespace phiz
