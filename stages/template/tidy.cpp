#include "stages/template/tidy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "stages/template/improve.h"

namespace phiz {

namespace {

/// Looks for a place beside a vertex where the sharpest of its triangles is less sharp.
class Widener {
 public:
  explicit Widener(ControlMesh& mesh) : mesh_(mesh), around_(mesh.positions.size()) {
    for (const auto& t : mesh.triangles) {
      for (int k = 0; k < 3; ++k) around_[t[k]].push_back(t);
    }
  }

  /// Whether a better place was found and taken.
  bool move(int v, double step_mm) {
    const Eigen::Vector3d normal = compute_normal(v), start = mesh_.positions[v];
    const Eigen::Vector3d side = normal.unitOrthogonal(), other = normal.cross(side);
    Eigen::Vector3d best = start;
    double widest = min_angle_at(v);
    constexpr int kDirections = 12;
    for (int k = 0; k < kDirections; ++k) {
      const double angle = 2 * 3.14159265358979323846 * k / kDirections;
      place(v, start + step_mm * (std::cos(angle) * side + std::sin(angle) * other));
      const double here = min_angle_at(v);
      if (here > widest + 1e-6) widest = here, best = mesh_.positions[v];
    }
    place(v, best);
    return best != start;
  }

 private:
  void place(int v, Eigen::Vector3d p) {
    const int image = mesh_.annotations.mirror[v];
    if (image == v) p[0] = 0;
    p = p.unaryExpr(&on_grain).eval();
    mesh_.positions[image] = {-p[0], p[1], p[2]};
    mesh_.positions[v] = p;
  }

  Eigen::Vector3d compute_normal(int v) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const auto& t : around_[v]) {
      sum += (mesh_.positions[t[1]] - mesh_.positions[t[0]])
                 .cross(mesh_.positions[t[2]] - mesh_.positions[t[0]]);
    }
    return sum.normalized();
  }

  double min_angle_at(int v) const {
    const auto angles = min_angles_deg(mesh_.positions, around_[v]);
    return *std::min_element(angles.begin(), angles.end());
  }

  ControlMesh& mesh_;
  std::vector<std::vector<Eigen::Vector3i>> around_;
};

}  // namespace

double on_grain(double x) {
  constexpr double kGrain = 1e6;
  return std::round(x * kGrain) / kGrain;
}

void make_symmetric(ControlMesh& mesh) {
  const auto& mirror = mesh.annotations.mirror;
  for (std::size_t v = 0; v < mirror.size(); ++v) {
    const std::size_t w = static_cast<std::size_t>(mirror[v]);
    if (w < v) continue;
    auto &a = mesh.positions[v], &b = mesh.positions[w];
    const Eigen::Vector3d mean = (0.5 * (a + Eigen::Vector3d(-b[0], b[1], b[2]))).unaryExpr(&on_grain);
    a = mean;
    b = {-mean[0], mean[1], mean[2]};
    if (w == v) a[0] = 0;
  }
}

bool hold_back_sharp_triangles(ControlMesh& mesh, const std::vector<Eigen::Vector3d>& start,
                               double min_angle_deg) {
  constexpr int kMaxSteps = 60;
  for (int step = 0;; ++step) {
    const auto angles = min_angles_deg(mesh.positions, mesh.triangles);
    std::vector<bool> marked(mesh.positions.size(), false);
    bool any = false;
    for (std::size_t t = 0; t < angles.size(); ++t) {
      if (angles[t] >= min_angle_deg) continue;
      for (int k = 0; k < 3; ++k) {
        const int v = mesh.triangles[t][k];
        marked[v] = marked[mesh.annotations.mirror[v]] = any = true;
      }
    }
    if (!any || step == kMaxSteps) return !any;
    for (std::size_t v = 0; v < marked.size(); ++v) {
      if (marked[v]) mesh.positions[v] = start[v] + 0.8 * (mesh.positions[v] - start[v]);
    }
    make_symmetric(mesh);
  }
}

void widen_sharp_triangles(ControlMesh& mesh, double min_angle_deg) {
  constexpr int kMaxRounds = 30;
  Widener widener(mesh);
  for (int round = 0; round < kMaxRounds; ++round) {
    const auto angles = min_angles_deg(mesh.positions, mesh.triangles);
    bool moved = false;
    for (std::size_t t = 0; t < angles.size(); ++t) {
      if (angles[t] >= min_angle_deg) continue;
      for (int k = 0; k < 3; ++k) {
        for (const double step_mm : {0.2, 0.05}) moved = widener.move(mesh.triangles[t][k], step_mm) || moved;
      }
    }
    if (!moved) return;
  }
}

}  // namespace phiz
