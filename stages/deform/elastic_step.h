#pragma once

#include <Eigen/Core>
#include <vector>

namespace phiz {

/// An elastic fit after so many iterations, as a StepKeeper keeps it.
struct ElasticStep {
  int iterations = 0;
  double mean_distance_mm = 0;
  std::vector<Eigen::Vector3d> positions;

  std::vector<double> numbers() const {
    std::vector<double> all = {static_cast<double>(iterations), mean_distance_mm};
    for (const Eigen::Vector3d& p : positions) all.insert(all.end(), {p.x(), p.y(), p.z()});
    return all;
  }

  /// False, and nothing changed, where the numbers are of another mesh.
  bool read(const std::vector<double>& all) {
    if (all.size() != 2 + 3 * positions.size()) return false;
    iterations = static_cast<int>(all[0]);
    mean_distance_mm = all[1];
    for (std::size_t v = 0; v < positions.size(); ++v)
      positions[v] = {all[2 + 3 * v], all[3 + 3 * v], all[4 + 3 * v]};
    return true;
  }
};

}  // namespace phiz
