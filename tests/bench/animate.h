#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "stages/animate/animate.h"
#include "tests/bench/areas.h"

namespace phiz::bench {

/// A fitted subject as animation takes it.
struct AnimateSubject {
  std::string name;
  std::vector<Eigen::Vector3f> control;
  std::vector<std::vector<float>> displacements_mm;
};

/// Three fitted scans of the data, and what all subjects share.
struct AnimateWorld {
  const BenchWorld& bench;
  std::filesystem::path store;
  std::vector<AnimateSubject> subjects;
  std::shared_ptr<const SurfacePlan> plan;  ///< to level 4
};

/// Processor seconds of this thread for one call: the fastest and the median of the runs after a warm-up.
struct RunTimes {
  double best_s = 0, median_s = 0;
};
RunTimes measure_times(int runs, const std::function<void()>& work);

/// Bytes a second that one thread reads and writes in a triad far larger than the caches.
double measure_bandwidth();

void measure_living_surface(const AnimateWorld& world);  ///< animate_surface.cpp
void measure_skin(const AnimateWorld& world);            ///< animate_skin.cpp

}  // namespace phiz::bench
