#include "stages/ingest/pose_polish.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "stages/geometry/normals.h"
#include "stages/geometry/parallel.h"
#include "stages/geometry/point_grid.h"
#include "stages/geometry/point_index.h"

namespace phiz {
namespace {

using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

struct ModelSample {
  Eigen::Vector3d position, normal;
  double weight;
};

/// Vertices of the generic head that a scanner sees, with their normals.
std::vector<ModelSample> sample_model(const ControlMesh& head) {
  const auto normals = compute_vertex_normals(head.positions, head.triangles);
  std::vector<double> weights(head.positions.size(), 0.4);
  const auto set = [&](const char* region, double weight) {
    const auto it = head.annotations.regions.find(region);
    if (it == head.annotations.regions.end()) return;
    for (const int v : it->second) weights[v] = weight;
  };
  set("face", 1.0);
  set("ears", 0.7);
  set("neck", 0.15);
  set("scalp", 0.3);
  set("inner_mouth", 0.0);
  set("nostrils", 0.0);
  std::vector<ModelSample> samples;
  for (std::size_t v = 0; v < weights.size(); ++v)
    if (weights[v] > 0) samples.push_back({head.positions[v], normals[v], weights[v]});
  return samples;
}

/// Mean points and unsigned normals of the scan's lattice cells of about 3 mm.
struct ScanPlanes {
  std::vector<Eigen::Vector3f> positions, normals;
};

ScanPlanes find_planes(std::span<const Eigen::Vector3f> scan, float cell) {
  const PointGrid grid(scan, cell);
  std::vector<Eigen::Vector3f> mean(grid.cell_count()), normal(grid.cell_count());
  std::vector<char> used(grid.cell_count(), 0);
  parallel_for(grid.cell_count(), 8192, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      if (grid.cell_begin(c) == grid.cell_end(c)) continue;
      const Eigen::Vector3f seed = grid.sorted_points()[grid.cell_begin(c)];
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      Eigen::Matrix3f moments = Eigen::Matrix3f::Zero();
      int count = 0;
      grid.for_each_within(seed, 1.5f * cell, [&](int slot, float) {
        const Eigen::Vector3f d = grid.sorted_points()[slot] - seed;
        sum += d;
        moments += d * d.transpose();
        ++count;
      });
      if (count < 6) continue;
      sum /= float(count);
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
      solver.computeDirect(moments / float(count) - sum * sum.transpose());
      normal[c] = solver.eigenvectors().col(0);
      if (!normal[c].allFinite()) continue;
      mean[c] = seed + sum.dot(normal[c]) * normal[c];
      used[c] = 1;
    }
  });
  ScanPlanes planes;
  for (std::size_t c = 0; c < used.size(); ++c) {
    if (!used[c]) continue;
    planes.positions.push_back(mean[c]);
    planes.normals.push_back(normal[c]);
  }
  return planes;
}

class Polisher {
 public:
  Polisher(ScanPlanes planes, const ControlMesh& head)
      : planes_(std::move(planes)), index_(planes_.positions), samples_(sample_model(head)) {}

  void polish(SimilarityPose& pose) const {
    for (int i = 0; i < 18; ++i) step(pose, i < 6 ? 25.0 : i < 12 ? 15.0 : 8.0);
    pose.score = mismatch(pose);
  }

 private:
  static constexpr double kNormalMm = 22.0;    ///< a normal off by one radian counts like so many millimetres
  static constexpr double kTruncation = 14.0;  ///< mm, of the mismatch

  struct Match {
    int plane_idx = -1;
    double squared_cost = 0;  ///< model mm^2
    Eigen::Vector3d normal;   ///< turned like the sample's
  };

  Match find(const SimilarityPose& pose, const ModelSample& sample,
             std::vector<PointIndex::Neighbour>& near) const {
    const Eigen::Vector3d q = pose.scale * (pose.rotation * sample.position) + pose.translation;
    const Eigen::Vector3d n = pose.rotation * sample.normal;
    index_.find_nearest(q.cast<float>(), 10, near);
    Match best;
    for (const auto& neighbour : near) {
      Eigen::Vector3d m = planes_.normals[neighbour.point_idx].cast<double>();
      if (m.dot(n) < 0) m = -m;
      const double cost = neighbour.squared_distance / (pose.scale * pose.scale) +
                          kNormalMm * kNormalMm * (m - n).squaredNorm();
      if (best.plane_idx < 0 || cost < best.squared_cost) best = {neighbour.point_idx, cost, m};
    }
    return best;
  }

  void step(SimilarityPose& pose, double width) const {
    Matrix7d a = Matrix7d::Zero();
    Vector7d b = Vector7d::Zero();
    std::vector<PointIndex::Neighbour> near;
    for (const ModelSample& sample : samples_) {
      const Match match = find(pose, sample, near);
      if (match.plane_idx < 0) continue;
      const Eigen::Vector3d y = pose.rotation * sample.position;  // model mm, turned
      const Eigen::Vector3d target =
          (planes_.positions[match.plane_idx].cast<double>() - pose.translation) / pose.scale;
      const double relative = match.squared_cost / (width * width);
      const double w = sample.weight / std::pow(1 + relative, 2);
      accumulate(y, match.normal, match.normal.dot(y - target), w, a, b);
      for (int axis = 0; axis < 3; ++axis)  // a little point to point: keeps a ball from spinning
        accumulate(y, Eigen::Vector3d::Unit(axis), (y - target)[axis], 0.1 * w, a, b);
    }
    a.diagonal().array() += 1e-6 * a.trace() + 1e-12;
    const Vector7d delta = a.ldlt().solve(-b);
    if (!delta.allFinite()) return;
    const double angle = delta.head<3>().norm();
    if (angle > 1e-12)
      pose.rotation =
          Eigen::AngleAxisd(std::min(angle, 0.3), delta.head<3>() / angle).toRotationMatrix() * pose.rotation;
    pose.translation += pose.scale * delta.segment<3>(3);
    pose.scale *= std::exp(std::clamp(delta[6], -0.1, 0.1));
  }

  static void accumulate(const Eigen::Vector3d& y, const Eigen::Vector3d& n, double r, double w, Matrix7d& a,
                         Vector7d& b) {
    Vector7d j;
    j << y.cross(n), n, n.dot(y);
    a.noalias() += w * j * j.transpose();
    b.noalias() += w * r * j;
  }

  double mismatch(const SimilarityPose& pose) const {
    double sum = 0, total = 0;
    std::vector<PointIndex::Neighbour> near;
    for (const ModelSample& sample : samples_) {
      const Match match = find(pose, sample, near);
      const double cost = match.plane_idx < 0 ? kTruncation : std::sqrt(match.squared_cost);
      sum += sample.weight * std::min(cost, kTruncation);
      total += sample.weight;
    }
    return sum / (total * kTruncation);
  }

  ScanPlanes planes_;
  PointIndex index_;
  std::vector<ModelSample> samples_;
};

}  // namespace

void polish_poses(std::span<const Eigen::Vector3f> scan, float spacing, const ControlMesh& generic_head,
                  std::vector<SimilarityPose>& poses) {
  if (poses.empty()) return;
  const float cell = std::max(static_cast<float>(3.0 * poses.front().scale), 1.3f * spacing);
  const Polisher polisher(find_planes(scan, cell), generic_head);
  parallel_for(poses.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) polisher.polish(poses[i]);
  });
  std::stable_sort(poses.begin(), poses.end(),
                   [](const SimilarityPose& x, const SimilarityPose& y) { return x.score < y.score; });
}

}  // namespace phiz
