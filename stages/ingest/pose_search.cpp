#include "stages/ingest/pose_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "stages/geometry/distance_lattice.h"
#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

constexpr float kTruncationMm = 20.0f;  ///< model millimetres; beyond it a distance says only "not here"

using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

/// Outer-surface samples of the generic head, evenly spread.
std::vector<Eigen::Vector3f> sample_model(const ControlMesh& head, double spacing_mm) {
  std::vector<char> hidden(head.positions.size(), 0);
  for (const char* name : {"inner_mouth", "nostrils"}) {
    if (const auto it = head.annotations.regions.find(name); it != head.annotations.regions.end())
      for (const int v : it->second) hidden[v] = 1;
  }
  std::vector<Eigen::Vector3f> samples;
  for (const auto& t : head.triangles) {
    if (hidden[t[0]] || hidden[t[1]] || hidden[t[2]]) continue;
    const Eigen::Vector3d a = head.positions[t[0]], b = head.positions[t[1]], c = head.positions[t[2]];
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const int n = std::max(1, static_cast<int>(std::ceil(longest / spacing_mm)));
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n - i; ++j)
        samples.push_back((a + (b - a) * (i + 1.0 / 3) / n + (c - a) * (j + 1.0 / 3) / n).cast<float>());
  }
  return samples;
}

/// Greedy thinning on a lattice: the first point of each cell.
std::vector<Eigen::Vector3f> thin(std::span<const Eigen::Vector3f> points, float cell) {
  std::set<std::array<int, 3>> seen;
  std::vector<Eigen::Vector3f> kept;
  for (const auto& p : points) {
    const Eigen::Array3i c = (p.array() / cell).floor().cast<int>();
    if (seen.insert({c.x(), c.y(), c.z()}).second) kept.push_back(p);
  }
  return kept;
}

std::vector<Eigen::Vector3f> every_nth(std::span<const Eigen::Vector3f> points, std::size_t target) {
  std::vector<Eigen::Vector3f> kept;
  for (std::size_t i = 0; i < std::min(target, points.size()); ++i)
    kept.push_back(points[i * points.size() / std::min(target, points.size())]);
  return kept;
}

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& omega) {
  const double angle = omega.norm();
  return angle < 1e-12 ? Eigen::Matrix3d::Identity()
                       : Eigen::AngleAxisd(angle, omega / angle).toRotationMatrix();
}

class PoseProblem {
 public:
  PoseProblem(std::span<const Eigen::Vector3f> scan, const ControlMesh& head)
      : model_dense_(sample_model(head, 4.0)),
        model_lattice_(model_dense_, 60.0f, 96),
        scan_lattice_(scan, 0.05f * extent(scan), 112) {
    const auto it = head.annotations.clipping_planes.find("neck");
    if (it == head.annotations.clipping_planes.end())
      throw InvalidInput("the generic head has no clipping plane `neck`",
                         "samples/generic_head/head.json has all that is needed");
    neck_ = it->second;
    for (const auto& p : model_dense_) model_box_.extend(p);
    if (const auto face = head.annotations.regions.find("face"); face != head.annotations.regions.end())
      for (const int v : face->second) face_box_.extend(head.positions[v].cast<float>());
    face_box_ = face_box_.isEmpty()
                    ? model_box_
                    : Eigen::AlignedBox3f(face_box_.min().array() - 8.0f, face_box_.max().array() + 8.0f);
    model_ = thin(model_dense_, 14.0f);
    scan_.assign(scan.begin(), scan.end());
    coarse_model_ = every_nth(model_, 160);
    coarse_scan_ = every_nth(scan_, 240);
  }

  double score(const SimilarityPose& pose, bool coarse) const {
    const auto& model = coarse ? coarse_model_ : model_;
    const auto& scan = coarse ? coarse_scan_ : scan_;
    const Eigen::Matrix3f forward = (pose.scale * pose.rotation).cast<float>();
    const Eigen::Matrix3f backward = (pose.rotation.transpose() / pose.scale).cast<float>();
    const Eigen::Vector3f t = pose.translation.cast<float>();
    const float inverse_scale = static_cast<float>(1.0 / pose.scale);
    double model_sum = 0, scan_sum = 0, model_weight = 0, counted = 0;
    for (const auto& p : model) {
      const float w = significance(p);
      model_weight += w;
      model_sum += w * std::min(scan_lattice_.at(forward * p + t).distance * inverse_scale, kTruncationMm);
    }
    for (const auto& q : scan) {
      const Eigen::Vector3f p = backward * (q - t);
      if (!above_neck(p)) continue;
      const float w = significance(p);
      counted += w;
      scan_sum += w * std::min(model_lattice_.at(p).distance, kTruncationMm);
    }
    const double model_term = model_sum / (kTruncationMm * model_weight);
    const double scan_term = counted == 0 ? 1.0 : scan_sum / (kTruncationMm * counted);
    return 0.5 * (model_term + scan_term);
  }

  /// Gauss-Newton on both distance terms with Geman-McClure weights of width `width_mm`.
  void refine(SimilarityPose& pose, int iterations, float width_mm, bool coarse) const {
    for (int i = 0; i < iterations; ++i) {
      Matrix7d a = Matrix7d::Zero();
      Vector7d b = Vector7d::Zero();
      accumulate_model(pose, width_mm, coarse ? coarse_model_ : model_, a, b);
      accumulate_scan(pose, width_mm, coarse ? coarse_scan_ : scan_, a, b);
      const double damping = 1e-3 * a.trace() / 7 + 1e-12;
      a.diagonal().array() += damping;
      const Vector7d step = a.ldlt().solve(-b);
      if (!step.allFinite()) return;
      const double limit = std::min(1.0, 0.35 / std::max(1e-12, step.head<3>().norm()));
      pose.rotation = rotation_of(limit * step.head<3>()) * pose.rotation;
      pose.translation += limit * step.segment<3>(3) * pose.scale;
      pose.scale *= std::exp(std::clamp(limit * step[6], -0.2, 0.2));
    }
  }

  /// First poses for one rotation: the crown is the top of the turned scan, the size a share of its height.
  void initial_poses(const Eigen::Matrix3d& model_from_scan_axes, std::vector<SimilarityPose>& out) const {
    std::vector<Eigen::Vector3f> turned;
    std::vector<float> heights;
    for (const auto& q : coarse_scan_) {
      turned.push_back(model_from_scan_axes.cast<float>() * q);
      heights.push_back(turned.back().y());
    }
    std::sort(heights.begin(), heights.end());
    const float top = heights[heights.size() * 995 / 1000], bottom = heights[heights.size() * 5 / 1000];
    const float model_height = model_box_.max().y() - model_box_.min().y();
    for (const double share : {1.05, 0.82, 0.64, 0.50, 0.36}) {
      const float head_height = static_cast<float>(share) * (top - bottom);
      Eigen::AlignedBox3f box;
      for (const auto& p : turned)
        if (p.y() > top - 0.7f * head_height) box.extend(p);
      if (box.isEmpty() || head_height <= 0) continue;
      SimilarityPose pose;
      pose.scale = head_height / model_height;
      pose.rotation = model_from_scan_axes.transpose();
      const Eigen::Vector3f model_anchor(model_box_.center().x(), model_box_.max().y(),
                                         model_box_.center().z());
      const Eigen::Vector3f scan_anchor(box.center().x(), top, box.center().z());
      pose.translation =
          pose.rotation * (scan_anchor.cast<double>() - pose.scale * model_anchor.cast<double>());
      out.push_back(pose);
    }
  }

 private:
  static float extent(std::span<const Eigen::Vector3f> points) {
    Eigen::AlignedBox3f box;
    for (const auto& p : points) box.extend(p);
    return box.diagonal().norm();
  }

  bool above_neck(const Eigen::Vector3f& p) const {
    return neck_.normal.cast<float>().dot(p) >= static_cast<float>(neck_.offset_mm);
  }

  /// The face tells heads' poses apart; hair, scalp and neck vary.
  float significance(const Eigen::Vector3f& p) const { return face_box_.contains(p) ? 1.0f : 0.35f; }

  static double weight(float distance, float width) {
    const double r = distance / width, w = 1.0 / (1.0 + r * r);
    return w * w;
  }

  void accumulate_model(const SimilarityPose& pose, float width, const std::vector<Eigen::Vector3f>& samples,
                        Matrix7d& a, Vector7d& b) const {
    const double share = 1.0 / samples.size();
    for (const auto& p : samples) {
      const Eigen::Vector3d y = pose.rotation * p.cast<double>();  // model mm, turned
      const auto s = scan_lattice_.at((pose.scale * y + pose.translation).cast<float>());
      const double r = s.distance / pose.scale;
      const Eigen::Vector3d g = s.gradient.cast<double>();
      Vector7d j;
      j << y.cross(g), g, g.dot(y) - r;
      const double w = share * significance(p) * weight(static_cast<float>(r), width);
      a.noalias() += w * j * j.transpose();
      b.noalias() += w * r * j;
    }
  }

  void accumulate_scan(const SimilarityPose& pose, float width, const std::vector<Eigen::Vector3f>& samples,
                       Matrix7d& a, Vector7d& b) const {
    const double share = 1.0 / samples.size();
    for (const auto& q : samples) {
      const Eigen::Vector3d y = (q.cast<double>() - pose.translation) / pose.scale;
      const Eigen::Vector3d p = pose.rotation.transpose() * y;
      if (!above_neck(p.cast<float>())) continue;
      const auto s = model_lattice_.at(p.cast<float>());
      const Eigen::Vector3d g = pose.rotation * s.gradient.cast<double>();
      Vector7d j;
      j << -y.cross(g), -g, -g.dot(y);
      const double w = share * significance(p.cast<float>()) * weight(s.distance, width);
      a.noalias() += w * j * j.transpose();
      b.noalias() += w * s.distance * j;
    }
  }

  std::vector<Eigen::Vector3f> model_dense_, model_, coarse_model_, scan_, coarse_scan_;
  DistanceLattice model_lattice_, scan_lattice_;
  Eigen::AlignedBox3f model_box_, face_box_;
  Plane neck_;
};

/// 60 directions of "up" on a Fibonacci sphere times 12 rolls: neighbours about 25 degrees apart.
std::vector<Eigen::Matrix3d> rotation_grid() {
  std::vector<Eigen::Matrix3d> grid;
  constexpr int kDirections = 60, kRolls = 12;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int d = 0; d < kDirections; ++d) {
    const double y = 1 - 2 * (d + 0.5) / kDirections, r = std::sqrt(1 - y * y);
    const Eigen::Vector3d up(r * std::cos(golden * d), y, r * std::sin(golden * d));
    const Eigen::Quaterniond to_up = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitY(), up);
    for (int k = 0; k < kRolls; ++k) {
      const Eigen::AngleAxisd roll(2 * std::numbers::pi * (k + 0.5 * (d % 2)) / kRolls,
                                   Eigen::Vector3d::UnitY());
      grid.push_back((to_up * roll).toRotationMatrix().transpose());
    }
  }
  return grid;
}

void score_all(const PoseProblem& problem, std::vector<SimilarityPose>& poses, bool coarse) {
  parallel_for(poses.size(), 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) poses[i].score = problem.score(poses[i], coarse);
  });
  std::stable_sort(poses.begin(), poses.end(),
                   [](const SimilarityPose& x, const SimilarityPose& y) { return x.score < y.score; });
}

void refine_all(const PoseProblem& problem, std::vector<SimilarityPose>& poses, int iterations,
                float width_mm, bool coarse) {
  parallel_for(poses.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) problem.refine(poses[i], iterations, width_mm, coarse);
  });
}

std::vector<SimilarityPose> distinct(const std::vector<SimilarityPose>& poses, std::size_t most,
                                     double apart_rad) {
  std::vector<SimilarityPose> kept;
  for (const auto& pose : poses) {
    const bool is_new = std::none_of(kept.begin(), kept.end(), [&](const SimilarityPose& other) {
      const Eigen::Matrix3d delta = pose.rotation.transpose() * other.rotation;
      return std::acos(std::clamp((delta.trace() - 1) / 2, -1.0, 1.0)) < apart_rad &&
             std::abs(std::log(pose.scale / other.scale)) < 0.15;
    });
    if (is_new) kept.push_back(pose);
    if (kept.size() == most) break;
  }
  return kept;
}

/// Poses near `pose` from which another valley of the score may be reached: nodded, turned, resized, lifted.
std::vector<SimilarityPose> neighbours(const SimilarityPose& pose) {
  std::vector<SimilarityPose> result;
  const auto add = [&](const Eigen::Vector3d& omega_model, double size, double lift_mm) {
    SimilarityPose p = pose;
    p.rotation = pose.rotation * rotation_of(omega_model);
    p.scale *= size;
    p.translation += pose.rotation * Eigen::Vector3d(0, lift_mm * pose.scale, 0);
    result.push_back(p);
  };
  for (const double nod : {-0.35, -0.17, 0.17, 0.35}) add({nod, 0, 0}, 1, 0);
  for (const double turn : {-0.2, 0.2}) add({0, turn, 0}, 1, 0);
  for (const double size : {0.9, 1.1}) add({0, 0, 0}, size, 0);
  for (const double lift : {-15.0, 15.0}) add({0, 0, 0}, 1, lift);
  return result;
}

}  // namespace

std::vector<SimilarityPose> search_pose(std::span<const Eigen::Vector3f> scan_points,
                                        const ControlMesh& generic_head) {
  if (scan_points.size() < 50)
    throw InvalidInput("only " + std::to_string(scan_points.size()) + " separate places in the scan");
  const PoseProblem problem(scan_points, generic_head);
  std::vector<SimilarityPose> poses;
  for (const auto& rotation : rotation_grid()) problem.initial_poses(rotation, poses);
  if (poses.empty()) throw InvalidInput("the scan has no extent");
  score_all(problem, poses, true);
  poses.resize(std::min<std::size_t>(poses.size(), 300));
  refine_all(problem, poses, 8, 15.0f, true);
  score_all(problem, poses, true);
  poses = distinct(poses, 30, 0.15);
  refine_all(problem, poses, 12, 10.0f, false);
  refine_all(problem, poses, 8, 6.0f, false);
  score_all(problem, poses, false);
  for (int round = 0; round < 2; ++round) {
    std::vector<SimilarityPose> around;
    for (std::size_t i = 0; i < std::min<std::size_t>(3, poses.size()); ++i)
      for (const auto& pose : neighbours(poses[i])) around.push_back(pose);
    refine_all(problem, around, 10, 10.0f, false);
    refine_all(problem, around, 8, 6.0f, false);
    score_all(problem, around, false);
    poses.insert(poses.end(), around.begin(), around.end());
    std::stable_sort(poses.begin(), poses.end(),
                     [](const SimilarityPose& x, const SimilarityPose& y) { return x.score < y.score; });
    poses = distinct(poses, 5, 0.06);
  }
  return poses;
}

}  // namespace phiz
