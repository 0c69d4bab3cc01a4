#include "stages/template/mapped_surface.h"

#include <algorithm>
#include <cmath>

#include "stages/geometry/error.h"
#include "stages/geometry/normals.h"

namespace phiz {
namespace {

int cell_of(double x, int count, double size) {
  return std::clamp(static_cast<int>(std::floor(x / size * count)), 0, count - 1);
}

double cross2(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a[0] * b[1] - a[1] * b[0];
}

/// Barycentric weights of p; not clamped.
Eigen::Vector3d weights_of(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                           const Eigen::Vector2d& c) {
  const double area = cross2(b - a, c - a);
  if (!(std::abs(area) > 0)) return {-1e9, -1e9, -1e9};
  const double wb = cross2(p - a, c - a) / area, wc = cross2(b - a, p - a) / area;
  return {1 - wb - wc, wb, wc};
}

}  // namespace

SurfaceLookup::SurfaceLookup(const MappedSurface& surface)
    : surface_(surface), normals_(compute_vertex_normals(surface.positions, surface.triangles)) {
  const double per_side = std::sqrt(static_cast<double>(surface.triangles.size()));
  cells_u_ = std::clamp(static_cast<int>(per_side / 2), 1, 512);
  cells_v_ = 2 * cells_u_;
  cells_.resize(static_cast<std::size_t>(cells_u_) * cells_v_);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& tri = surface.triangles[t];
    Eigen::Array2d low = surface.uv[tri[0]].array(), high = low;
    for (int k = 1; k < 3; ++k) {
      low = low.min(surface.uv[tri[k]].array());
      high = high.max(surface.uv[tri[k]].array());
    }
    constexpr double kMargin = 1e-6;
    for (int j = cell_of(low[1] - kMargin, cells_v_, 1); j <= cell_of(high[1] + kMargin, cells_v_, 1); ++j) {
      for (int i = cell_of(low[0] - kMargin, cells_u_, 0.5); i <= cell_of(high[0] + kMargin, cells_u_, 0.5);
           ++i) {
        cells_[static_cast<std::size_t>(j) * cells_u_ + i].push_back(static_cast<int>(t));
      }
    }
  }
}

SurfaceLookup::Place SurfaceLookup::find(const Eigen::Vector2d& uv) const {
  const int j = cell_of(uv[1], cells_v_, 1), i = cell_of(uv[0], cells_u_, 0.5);
  Place best;
  double best_min = -1e30;
  for (const int t : cells_[static_cast<std::size_t>(j) * cells_u_ + i]) {
    const auto& tri = surface_.triangles[t];
    const Eigen::Vector3d w = weights_of(uv, surface_.uv[tri[0]], surface_.uv[tri[1]], surface_.uv[tri[2]]);
    if (w.minCoeff() > best_min) best_min = w.minCoeff(), best = {t, w};
  }
  CONTRACT(best.triangle_idx >= 0);  // the map covers the half square
  best.weights = best.weights.cwiseMax(0);
  best.weights /= best.weights.sum();
  return best;
}

Eigen::Vector3d SurfaceLookup::position(const Place& place) const {
  const auto& tri = surface_.triangles[place.triangle_idx];
  return place.weights[0] * surface_.positions[tri[0]] + place.weights[1] * surface_.positions[tri[1]] +
         place.weights[2] * surface_.positions[tri[2]];
}

Eigen::Vector3d SurfaceLookup::normal(const Place& place) const {
  const auto& tri = surface_.triangles[place.triangle_idx];
  return (place.weights[0] * normals_[tri[0]] + place.weights[1] * normals_[tri[1]] +
          place.weights[2] * normals_[tri[2]])
      .normalized();
}

Eigen::Vector2d SurfaceLookup::descend_to(const Eigen::Vector3d& target, Eigen::Vector2d uv) const {
  const bool on_mirror = uv[0] == 0.5;
  double best = (position(uv) - target).squaredNorm();
  for (int step = 0; step < 30; ++step) {
    const Place place = find(uv);
    const Eigen::Matrix<double, 3, 2> slope = jacobian(place);
    Eigen::Vector2d change =
        (slope.transpose() * slope).ldlt().solve(slope.transpose() * (target - position(place)));
    if (on_mirror) change[0] = 0;
    bool moved = false;
    for (double length = 1; length > 0.03 && !moved; length *= 0.5) {
      const Eigen::Vector2d next = uv + length * change;
      if (next[0] <= 0 || next[1] <= 0 || next[1] >= 1 || (next[0] >= 0.5 && !on_mirror)) continue;
      const double distance = (position(next) - target).squaredNorm();
      if (distance < best * (1 - 1e-6)) uv = next, best = distance, moved = true;
    }
    if (!moved) break;
  }
  return uv;
}

Eigen::Matrix<double, 3, 2> SurfaceLookup::jacobian(const Place& place) const {
  const auto& tri = surface_.triangles[place.triangle_idx];
  Eigen::Matrix2d duv;
  duv << surface_.uv[tri[1]] - surface_.uv[tri[0]], surface_.uv[tri[2]] - surface_.uv[tri[0]];
  Eigen::Matrix<double, 3, 2> dp;
  dp << surface_.positions[tri[1]] - surface_.positions[tri[0]],
      surface_.positions[tri[2]] - surface_.positions[tri[0]];
  return dp * duv.inverse();
}

}  // namespace phiz
