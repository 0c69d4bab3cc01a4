#include <algorithm>
#include <cmath>

#include "stages/evaluate/evaluate.h"
#include "stages/geometry/error.h"

namespace phiz {
namespace {

constexpr std::uint8_t kMeasured = 192, kBridged = 64;

double nearest_rank(const std::vector<double>& sorted, double percent) {
  const double rank = std::ceil(percent / 100 * static_cast<double>(sorted.size()));
  return sorted[static_cast<std::size_t>(std::max(1.0, rank)) - 1];
}

}  // namespace

ErrorStats compute_error_stats(std::span<const double> distances_mm) {
  ErrorStats stats;
  stats.count = distances_mm.size();
  if (distances_mm.empty()) return stats;
  std::vector<double> sorted(distances_mm.begin(), distances_mm.end());
  std::sort(sorted.begin(), sorted.end());
  CONTRACT(std::isfinite(sorted.front()) && std::isfinite(sorted.back()));
  double sum = 0;
  for (const double distance : sorted) sum += distance;
  stats.mean = sum / static_cast<double>(sorted.size());
  stats.median = nearest_rank(sorted, 50);
  stats.p95 = nearest_rank(sorted, 95);
  stats.p99 = nearest_rank(sorted, 99);
  stats.max = sorted.back();
  return stats;
}

std::string name_confidence(std::uint8_t confidence) {
  if (confidence >= kMeasured) return "measured";
  return confidence >= kBridged ? "bridged" : "invented";
}

Regions refine_regions(const SubdivisionHierarchy& hierarchy, const Annotations& annotations, int level) {
  Regions regions;
  for (const auto& [name, vertices] : annotations.regions) {
    std::vector<bool>& flags = regions[name];
    flags.assign(hierarchy.vertex_count(0), false);
    for (const int vertex_idx : vertices) flags.at(vertex_idx) = true;
  }
  const auto face = regions.find("face"), ears = regions.find("ears");
  if (face != regions.end() && ears != regions.end()) {
    std::vector<bool> both = face->second;
    for (std::size_t v = 0; v < both.size(); ++v) both[v] = both[v] || ears->second[v];
    regions["face_and_ears"] = both;
  }
  for (auto& [name, flags] : regions) {
    for (int fine = 1; fine <= level; ++fine) {
      for (int v = hierarchy.vertex_count(fine - 1); v < hierarchy.vertex_count(fine); ++v) {
        const Eigen::Vector2i parents = hierarchy.parents(fine, v);
        flags.push_back(flags[parents[0]] && flags[parents[1]]);
      }
    }
  }
  return regions;
}

std::map<std::string, double> compute_landmark_errors(const std::map<std::string, Eigen::Vector3d>& fitted,
                                                      const std::map<std::string, Eigen::Vector3d>& truth) {
  std::map<std::string, double> errors;
  for (const auto& [name, position] : fitted) {
    const auto other = truth.find(name);
    if (other != truth.end()) errors[name] = (position - other->second).norm();
  }
  return errors;
}

}  // namespace phiz
