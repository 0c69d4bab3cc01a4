#include "stages/ingest/orient.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "stages/geometry/point_grid.h"
#include "stages/geometry/point_index.h"

namespace phiz {
namespace {

struct Plane3 {
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();
  float distance = 0;  ///< of the query to the plane
  float scatter = 0;   ///< standard deviation about the plane
  float density = 0;
};

Plane3 fit_plane(const PointGrid& grid, const Eigen::Vector3f& query, float radius) {
  Eigen::Matrix3f moments;
  Eigen::Vector3f sum;
  int count = 0;
  for (int attempt = 0; attempt < 4; ++attempt, radius *= 2) {
    moments.setZero();
    sum.setZero();
    count = 0;
    grid.for_each_within(query, radius, [&](int slot, float) {
      const Eigen::Vector3f d = grid.sorted_points()[slot] - query;
      sum += d;
      moments += d * d.transpose();
      ++count;
    });
    if (count >= 10) break;
  }
  Plane3 plane;
  if (count < 3) return plane;
  const Eigen::Vector3f mean = sum / float(count);
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
  solver.computeDirect(moments / float(count) - mean * mean.transpose());
  plane.normal = solver.eigenvectors().col(0).normalized();
  if (!plane.normal.allFinite()) plane.normal = Eigen::Vector3f::UnitZ();
  plane.distance = std::abs(plane.normal.dot(mean));
  plane.scatter = std::sqrt(std::max(0.0f, solver.eigenvalues()[0]));
  plane.density = count / (std::numbers::pi_v<float> * radius * radius);
  return plane;
}

/// Rays through the occupied cells of a lattice.
class Visibility {
 public:
  Visibility(const PointGrid& grid) : grid_(grid) {
    occupied_.resize(grid.cell_count());
    for (std::size_t c = 0; c < occupied_.size(); ++c) occupied_[c] = grid.cell_end(c) > grid.cell_begin(c);
    // Directions in a cone of 65 degrees about +z: one ring of five and one of nine.
    for (int i = 0; i < 14; ++i) {
      const float tilt = (i < 5 ? 28.0f : 60.0f) * std::numbers::pi_v<float> / 180;
      const float turn = (i < 5 ? i / 5.0f : (i - 5) / 9.0f) * 2 * std::numbers::pi_v<float>;
      cone_.push_back({std::sin(tilt) * std::cos(turn), std::sin(tilt) * std::sin(turn), std::cos(tilt)});
    }
  }

  /// Share of the cone about `axis` that is open, by how far the rays get.
  float openness(const Eigen::Vector3f& p, const Eigen::Vector3f& axis) const {
    Eigen::Matrix3f frame;
    frame.col(2) = axis;
    frame.col(0) = axis.unitOrthogonal();
    frame.col(1) = axis.cross(frame.col(0));
    float open = 0;
    for (const auto& d : cone_) open += reach(p, frame * d);
    return open / cone_.size();
  }

 private:
  float reach(const Eigen::Vector3f& p, const Eigen::Vector3f& direction) const {
    const float step = grid_.cell();
    for (int k = 0; k < 128; ++k) {
      const Eigen::Vector3i c = grid_.coordinates(p + (2.2f + k) * step * direction);
      if (!grid_.contains(c)) return 1.0f;
      if (occupied_[grid_.cell_index(c)]) return std::min(0.2f, k / 100.0f);
    }
    return 1.0f;
  }

  const PointGrid& grid_;
  std::vector<char> occupied_;
  std::vector<Eigen::Vector3f> cone_;
};

/// Which way the guide's surface faces where it runs most alike: in [-1, 1], near 0 far from the guide.
float guide_vote(const OrientationGuide& guide, const PointIndex& index, const Eigen::Vector3f& p,
                 const Eigen::Vector3f& n, std::vector<PointIndex::Neighbour>& near) {
  constexpr float kReachMm = 14.0f, kNormalMm = 10.0f;
  index.find_nearest(p, 12, near);
  float best_cost = std::numeric_limits<float>::max(), vote = 0;
  for (const auto& neighbour : near) {
    const float along = guide.normals[neighbour.point_idx].dot(n);
    const float cost = neighbour.squared_distance + 2 * kNormalMm * kNormalMm * (1 - std::abs(along));
    if (cost >= best_cost) continue;
    best_cost = cost;
    vote = along * std::exp(-cost / (kReachMm * kReachMm));
  }
  return vote;
}

/// Turns the normals of each cell's points outward. One line of sight test a cell and sheet.
void orient(const PointGrid& coarse, const OrientationGuide& guide, std::vector<Eigen::Vector3f>& normals) {
  const Visibility visibility(coarse);
  const PointIndex index(guide.positions);
  parallel_for(coarse.cell_count(), 8192, [&](std::size_t begin, std::size_t end) {
    std::vector<PointIndex::Neighbour> near;
    for (std::size_t c = begin; c < end; ++c) {
      std::vector<Eigen::Vector3f> sheets;  // outward normals decided so far in this cell
      for (int slot = coarse.cell_begin(c); slot < coarse.cell_end(c); ++slot) {
        Eigen::Vector3f& n = normals[coarse.order()[slot]];
        const Eigen::Vector3f* best = nullptr;
        for (const auto& s : sheets)
          if (std::abs(s.dot(n)) > 0.8f && (!best || std::abs(s.dot(n)) > std::abs(best->dot(n)))) best = &s;
        if (best) {
          if (best->dot(n) < 0) n = -n;
          continue;
        }
        const Eigen::Vector3f& p = coarse.sorted_points()[slot];
        const float sight = visibility.openness(p, n) - visibility.openness(p, -n);
        if (sight + 0.5f * guide_vote(guide, index, p, n, near) < 0) n = -n;
        sheets.push_back(n);
      }
    }
  });
}

float median(std::vector<float> values) {
  if (values.empty()) return 0;
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

}  // namespace

NormalEstimate estimate_normals(PointCloud& cloud, float radius_mm, const OrientationGuide& guide) {
  const std::size_t count = cloud.size();
  const PointGrid grid(cloud.positions, radius_mm);
  cloud.normals.assign(count, Eigen::Vector3f::UnitZ());
  cloud.confidences.assign(count, 0.0f);
  std::vector<float> distances(count), densities(count);
  parallel_for(count, 2048, [&](std::size_t begin, std::size_t end) {
    for (std::size_t slot = begin; slot < end; ++slot) {
      const Plane3 plane = fit_plane(grid, grid.sorted_points()[slot], radius_mm);
      const int i = grid.order()[slot];
      cloud.normals[i] = plane.normal;
      const float relative = plane.scatter / 0.5f;
      cloud.confidences[i] = plane.density == 0 ? 0.0f : 1.0f / (1.0f + relative * relative);
      distances[i] = plane.distance;
      densities[i] = plane.density;
    }
  });
  const PointGrid coarse(cloud.positions, 1.25f * radius_mm);
  orient(coarse, guide, cloud.normals);
  return {median(std::move(distances)), median(std::move(densities))};
}

}  // namespace phiz
