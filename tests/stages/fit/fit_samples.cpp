#include "tests/stages/fit/fit_samples.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "stages/geometry/surface_index.h"
#include "tests/support/random.h"

namespace phiz::test {

const ControlMesh& generic_head() {
  static const ControlMesh head = read_generic_head();
  return head;
}

const SubdivisionHierarchy& generic_hierarchy() {
  static const SubdivisionHierarchy hierarchy(generic_head().triangles,
                                              static_cast<int>(generic_head().positions.size()), 2);
  return hierarchy;
}

PointCloud sample_surface(const ControlPositions& control, int count) {
  const auto positions = evaluate_surface(generic_hierarchy(), control, {}, 2);
  const auto& triangles = generic_hierarchy().triangles(2);
  std::vector<Eigen::Vector3d> normals;
  std::vector<double> cumulated;
  double total = 0;
  for (const auto& t : triangles) {
    normals.push_back((positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]));
    cumulated.push_back(total += normals.back().norm());
  }
  PointCloud cloud;
  Random random(1);  // its own: the same points whichever test comes first
  for (int i = 0; i < count; ++i) {
    const auto found = std::upper_bound(cumulated.begin(), cumulated.end(), (i + 0.5) / count * total);
    const std::size_t t_idx = std::min<std::size_t>(found - cumulated.begin(), triangles.size() - 1);
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const auto& t = triangles[t_idx];
    cloud.positions.push_back(
        ((1 - u - v) * positions[t[0]] + u * positions[t[1]] + v * positions[t[2]]).cast<float>());
    cloud.normals.push_back(normals[t_idx].normalized().cast<float>());
    cloud.confidences.push_back(1);
  }
  return cloud;
}

int count_folds(const ControlPositions& a, const ControlPositions& b) {
  const auto normal = [](const ControlPositions& p, const Eigen::Vector3i& t) -> Eigen::Vector3d {
    return (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]);
  };
  int folds = 0;
  for (const auto& t : generic_head().triangles) folds += normal(a, t).dot(normal(b, t)) < 0;
  return folds;
}

double mean_distance(const ControlPositions& a, const ControlPositions& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).norm();
  return sum / static_cast<double>(a.size());
}

double mean_surface_error(const ControlPositions& control, const ControlPositions& truth) {
  const auto& triangles = generic_hierarchy().triangles(2);
  std::vector<Eigen::Vector3f> surface;
  for (const auto& p : evaluate_surface(generic_hierarchy(), truth, {}, 2))
    surface.push_back(p.cast<float>());
  const SurfaceIndex index(surface, triangles);
  double sum = 0;
  const auto positions = evaluate_surface(generic_hierarchy(), control, {}, 2);
  for (const auto& p : positions) sum += index.find_nearest(p, 100.0)->distance;
  return sum / static_cast<double>(positions.size());
}

}  // namespace phiz::test
