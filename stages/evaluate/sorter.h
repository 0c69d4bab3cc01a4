#pragma once

#include "stages/evaluate/evaluate.h"

namespace phiz {

/// Distances sorted by region. A distance may belong to several regions or to none.
class RegionSorter {
 public:
  explicit RegionSorter(const Regions& regions) : regions_(regions) {}

  void add(int vertex_idx, double distance_mm) {
    for (const auto& [name, flags] : regions_) {
      if (flags[vertex_idx]) lists_[name].push_back(distance_mm);
    }
  }
  StatsByName compute_stats() const {
    StatsByName stats;
    for (const auto& [name, list] : lists_) stats[name] = compute_error_stats(list);
    return stats;
  }

 private:
  const Regions& regions_;
  std::map<std::string, std::vector<double>> lists_;
};

/// Throws InvalidInput where a region has not one flag per vertex.
void check_regions(const Regions& regions, std::size_t vertex_count);

}  // namespace phiz
