#include "stages/ingest/orient.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "stages/geometry/point_grid.h"
#include "stages/ingest/outward.h"

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
  turn_outward(coarse, guide, cloud.normals);
  return {median(std::move(distances)), median(std::move(densities))};
}

}  // namespace phiz
