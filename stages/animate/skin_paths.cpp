#include "stages/animate/skin_paths.h"

#include <algorithm>
#include <limits>
#include <queue>

namespace phiz {

SkinPaths::SkinPaths(std::span<const Eigen::Vector3d> positions, std::span<const Eigen::Vector3i> triangles)
    : positions_(positions.begin(), positions.end()), neighbours_(positions.size()) {
  for (const Eigen::Vector3i& t : triangles) {
    for (int i = 0; i < 3; ++i) {
      neighbours_[t[i]].push_back(t[(i + 1) % 3]);
      neighbours_[t[(i + 1) % 3]].push_back(t[i]);
    }
  }
  for (std::vector<int>& list : neighbours_) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
}

std::vector<double> SkinPaths::run(std::span<const std::pair<int, double>> seeds,
                                   std::vector<int>& before) const {
  std::vector<double> found(positions_.size(), std::numeric_limits<double>::infinity());
  before.assign(positions_.size(), -1);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (const auto& [vertex, distance] : seeds) {
    if (distance >= found[vertex]) continue;
    found[vertex] = distance;
    queue.emplace(distance, vertex);
  }
  while (!queue.empty()) {
    const auto [distance, v] = queue.top();
    queue.pop();
    if (distance > found[v]) continue;
    for (const int next : neighbours_[v]) {
      const double further = distance + (positions_[next] - positions_[v]).norm();
      if (further >= found[next]) continue;
      found[next] = further;
      before[next] = v;
      queue.emplace(further, next);
    }
  }
  return found;
}

std::vector<double> SkinPaths::distances(std::span<const std::pair<int, double>> seeds) const {
  std::vector<int> before;
  return run(seeds, before);
}

std::vector<int> SkinPaths::path(int from, int to) const {
  std::vector<int> before;
  const std::pair<int, double> seed{from, 0.0};
  run({&seed, 1}, before);
  std::vector<int> way;
  for (int v = to; v >= 0; v = before[v]) way.push_back(v);
  if (way.back() != from) return {};
  std::reverse(way.begin(), way.end());
  return way;
}

int SkinPaths::nearest(const Eigen::Vector3d& place) const {
  const auto closer = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return (a - place).squaredNorm() < (b - place).squaredNorm();
  };
  return static_cast<int>(std::min_element(positions_.begin(), positions_.end(), closer) -
                          positions_.begin());
}

}  // namespace phiz
