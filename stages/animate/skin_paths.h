#pragma once

#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

namespace phiz {

/// Ways along the edges of a mesh.
class SkinPaths {
 public:
  SkinPaths(std::span<const Eigen::Vector3d> positions, std::span<const Eigen::Vector3i> triangles);

  /// Distance of every vertex from the nearest seed (vertex, distance there); infinity where none reaches.
  /// Dijkstra, O(V log V).
  std::vector<double> distances(std::span<const std::pair<int, double>> seeds) const;
  /// Vertices of the shortest way, both ends in it. Empty where there is none.
  std::vector<int> path(int from, int to) const;
  int nearest(const Eigen::Vector3d& place) const;  ///< vertex

 private:
  std::vector<double> run(std::span<const std::pair<int, double>> seeds, std::vector<int>& before) const;
  std::vector<Eigen::Vector3d> positions_;
  std::vector<std::vector<int>> neighbours_;
};

}  // namespace phiz
