#include "stages/unwrap/uv_domain.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <string>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

constexpr double kAreaTolerance = 1e-4;  // (u,v) of a file have 16 bits or six decimals
constexpr double kSnap = 1e-12;

double turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

}  // namespace

UvDomain::UvDomain(std::span<const Eigen::Vector2d> uv, std::span<const Eigen::Vector3i> triangles)
    : uv_(uv.begin(), uv.end()), triangles_(triangles.begin(), triangles.end()) {
  double area = 0;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const Eigen::Vector3i& corners = triangles_[t];
    if (corners.minCoeff() < 0 || corners.maxCoeff() >= static_cast<int>(uv_.size()))
      throw InvalidInput("triangle " + std::to_string(t) + " has a corner without (u,v)");
    const double twice = turn(uv_[corners[0]], uv_[corners[1]], uv_[corners[2]]);
    if (!(twice > 0)) throw InvalidInput("triangle " + std::to_string(t) + " is turned over in (u,v)");
    area += twice / 2;
  }
  if (!(std::abs(area - 1) < kAreaTolerance))
    throw InvalidInput("the triangles do not fill the (u,v) square");

  cells_ = std::clamp(static_cast<int>(std::sqrt(static_cast<double>(triangles_.size()))), 1, 1024);
  const auto cell = [this](double x) { return std::clamp(static_cast<int>(x * cells_), 0, cells_ - 1); };
  const auto visit = [&](const auto& body) {
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      Eigen::AlignedBox2d box;
      for (const int corner : triangles_[t]) box.extend(uv_[corner]);
      const double margin = 1e-9;
      for (int y = cell(box.min().y() - margin); y <= cell(box.max().y() + margin); ++y)
        for (int x = cell(box.min().x() - margin); x <= cell(box.max().x() + margin); ++x)
          body(y * cells_ + x, static_cast<int>(t));
    }
  };
  cell_offsets_.assign(static_cast<std::size_t>(cells_) * cells_ + 1, 0);
  visit([&](int c, int) { ++cell_offsets_[c + 1]; });
  for (std::size_t c = 1; c < cell_offsets_.size(); ++c) cell_offsets_[c] += cell_offsets_[c - 1];
  cell_triangles_.resize(cell_offsets_.back());
  std::vector<int> next(cell_offsets_.begin(), cell_offsets_.end() - 1);
  visit([&](int c, int t) { cell_triangles_[next[c]++] = t; });
}

Eigen::Vector3d UvDomain::weights_in(int triangle_idx, const Eigen::Vector2d& uv) const {
  const Eigen::Vector3i& t = triangles_[triangle_idx];
  const Eigen::Vector2d &a = uv_[t[0]], &b = uv_[t[1]], &c = uv_[t[2]];
  return Eigen::Vector3d(turn(uv, b, c), turn(a, uv, c), turn(a, b, uv)) / turn(a, b, c);
}

SurfacePoint UvDomain::locate(const Eigen::Vector2d& uv) const {
  const auto clamped = [](double x) { return x > 0 ? std::min(x, 1.0) : 0.0; };  // NaN becomes 0
  const Eigen::Vector2d place(clamped(uv.x()), clamped(uv.y()));
  const int x = std::min(cells_ - 1, static_cast<int>(place.x() * cells_)),
            y = std::min(cells_ - 1, static_cast<int>(place.y() * cells_));
  SurfacePoint best;
  double best_least = -1e300;
  for (int k = cell_offsets_[y * cells_ + x]; k < cell_offsets_[y * cells_ + x + 1]; ++k) {
    const Eigen::Vector3d weights = weights_in(cell_triangles_[k], place);
    const double least = std::min(weights.minCoeff(), 0.0);
    if (least <= best_least) continue;
    best = {cell_triangles_[k], weights};
    best_least = least;
    if (least >= -kSnap) break;  // candidates come in ascending order
  }
  // Rounding only: the triangles fill the square but for the digits their (u,v) were kept with.
  for (double& weight : best.weights)
    if (weight < kSnap) weight = 0;
  best.weights /= best.weights.sum();
  for (double& weight : best.weights)
    if (weight > 1 - kSnap) weight = 1;
  return best;
}

SurfacePoint refine_place(const SurfacePoint& control_place, int level) {
  SurfacePoint place = control_place;
  for (int k = 0; k < level; ++k) {
    const Eigen::Vector3d w = place.weights;
    int corner = 3;
    for (int i = 0; i < 3; ++i)
      if (w[i] >= 0.5) corner = i;
    place.triangle_idx = 4 * place.triangle_idx + corner;
    if (corner == 3) {
      place.weights = {1 - 2 * w[2], 1 - 2 * w[0], 1 - 2 * w[1]};
    } else {
      const double ahead = 2 * w[(corner + 1) % 3], behind = 2 * w[(corner + 2) % 3];
      place.weights = {std::max(0.0, 1 - ahead - behind), ahead, behind};
    }
  }
  return place;
}

}  // namespace phiz
