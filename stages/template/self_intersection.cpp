#include "stages/template/self_intersection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

using Triangle = std::array<Eigen::Vector3d, 3>;

/// Signed distances of b's corners to a's plane, tiny ones set to zero.
Eigen::Vector3d plane_distances(const Triangle& a, const Triangle& b, Eigen::Vector3d& normal) {
  normal = (a[1] - a[0]).cross(a[2] - a[0]);
  const double scale = normal.norm();
  Eigen::Vector3d d;
  for (int k = 0; k < 3; ++k) d[k] = normal.dot(b[k] - a[0]);
  for (int k = 0; k < 3; ++k) {
    if (std::abs(d[k]) <= 1e-12 * scale * scale) d[k] = 0;
  }
  return d;
}

/// The part of a line (by coordinate) that a triangle covers, from distances of its corners to the line's
/// plane.
bool interval_on_line(const Eigen::Vector3d& coordinate, const Eigen::Vector3d& d, double& low,
                      double& high) {
  std::array<double, 2> ends{};
  int count = 0;
  for (int k = 0; k < 3 && count < 2; ++k) {
    const int next = (k + 1) % 3;
    if (d[k] * d[next] < 0) {
      ends[count++] = coordinate[k] + (coordinate[next] - coordinate[k]) * d[k] / (d[k] - d[next]);
    } else if (d[k] == 0 && count < 2) {
      ends[count++] = coordinate[k];
    }
  }
  if (count < 2) return false;
  low = std::min(ends[0], ends[1]);
  high = std::max(ends[0], ends[1]);
  return true;
}

bool cross_each_other(const Triangle& a, const Triangle& b) {
  Eigen::Vector3d normal_a, normal_b;
  const Eigen::Vector3d db = plane_distances(a, b, normal_a);
  if (db.minCoeff() >= 0 || db.maxCoeff() <= 0) return false;
  const Eigen::Vector3d da = plane_distances(b, a, normal_b);
  if (da.minCoeff() >= 0 || da.maxCoeff() <= 0) return false;
  const Eigen::Vector3d line = normal_a.cross(normal_b);
  Eigen::Vector3d ca, cb;
  for (int k = 0; k < 3; ++k) ca[k] = line.dot(a[k]), cb[k] = line.dot(b[k]);
  double low_a = 0, high_a = 0, low_b = 0, high_b = 0;
  if (!interval_on_line(ca, da, low_a, high_a) || !interval_on_line(cb, db, low_b, high_b)) return false;
  return std::max(low_a, low_b) < std::min(high_a, high_b);
}

/// Uniform cells; every triangle is in all cells its box touches.
class Cells {
 public:
  Cells(std::span<const Eigen::Vector3d> positions, std::span<const Eigen::Vector3i> triangles) {
    double edge = 0;
    low_ = high_ = positions[triangles[0][0]];
    for (const auto& t : triangles) {
      edge += (positions[t[1]] - positions[t[0]]).norm();
      for (int k = 0; k < 3; ++k)
        low_ = low_.cwiseMin(positions[t[k]]), high_ = high_.cwiseMax(positions[t[k]]);
    }
    size_ = std::max(1.5 * edge / static_cast<double>(triangles.size()), (high_ - low_).maxCoeff() / 500);
    for (int k = 0; k < 3; ++k) count_[k] = static_cast<int>((high_[k] - low_[k]) / size_) + 1;
    for (int t = 0; t < static_cast<int>(triangles.size()); ++t) {
      const auto& tri = triangles[t];
      const auto first = cell(positions[tri[0]].cwiseMin(positions[tri[1]]).cwiseMin(positions[tri[2]]));
      const auto last = cell(positions[tri[0]].cwiseMax(positions[tri[1]]).cwiseMax(positions[tri[2]]));
      for (int z = first[2]; z <= last[2]; ++z) {
        for (int y = first[1]; y <= last[1]; ++y) {
          for (int x = first[0]; x <= last[0]; ++x) {
            entries_.emplace_back((static_cast<std::int64_t>(z) * count_[1] + y) * count_[0] + x, t);
          }
        }
      }
    }
    std::sort(entries_.begin(), entries_.end());
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      if (i == 0 || entries_[i].first != entries_[i - 1].first) starts_.push_back(i);
    }
    starts_.push_back(entries_.size());
  }
  std::size_t cell_count() const { return starts_.size() - 1; }
  std::span<const std::pair<std::int64_t, int>> triangles_of(std::size_t c) const {
    return std::span(entries_).subspan(starts_[c], starts_[c + 1] - starts_[c]);
  }

 private:
  std::array<int, 3> cell(const Eigen::Vector3d& p) const {
    std::array<int, 3> c{};
    for (int k = 0; k < 3; ++k)
      c[k] = std::clamp(static_cast<int>((p[k] - low_[k]) / size_), 0, count_[k] - 1);
    return c;
  }
  Eigen::Vector3d low_, high_;
  double size_ = 1;
  std::array<int, 3> count_{};
  std::vector<std::pair<std::int64_t, int>> entries_;
  std::vector<std::size_t> starts_;
};

bool share_a_vertex(const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (a[i] == b[j]) return true;
    }
  }
  return false;
}

}  // namespace

std::vector<std::pair<int, int>> find_self_intersections(std::span<const Eigen::Vector3d> positions,
                                                         std::span<const Eigen::Vector3i> triangles) {
  if (triangles.empty()) return {};
  const Cells cells(positions, triangles);
  const auto corners = [&](int t) {
    const auto& tri = triangles[t];
    return Triangle{positions[tri[0]], positions[tri[1]], positions[tri[2]]};
  };
  constexpr std::size_t kGrain = 4096;
  std::vector<std::vector<std::pair<int, int>>> found((cells.cell_count() + kGrain - 1) / kGrain);
  parallel_for(cells.cell_count(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      const auto here = cells.triangles_of(c);
      for (std::size_t i = 0; i < here.size(); ++i) {
        const Triangle a = corners(here[i].second);
        for (std::size_t j = i + 1; j < here.size(); ++j) {
          const int s = here[i].second, t = here[j].second;
          if (share_a_vertex(triangles[s], triangles[t])) continue;
          if (cross_each_other(a, corners(t)))
            found[begin / kGrain].emplace_back(std::min(s, t), std::max(s, t));
        }
      }
    }
  });
  std::vector<std::pair<int, int>> all;
  for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

}  // namespace phiz
