#include "stages/template/tidy.h"

#include <cmath>

#include "stages/template/improve.h"

namespace phiz {

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

}  // namespace phiz
