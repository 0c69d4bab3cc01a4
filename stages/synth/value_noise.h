#pragma once

#include <Eigen/Core>
#include <cmath>

#include "stages/synth/random_stream.h"

namespace phiz {

/// Smooth noise in [0,1]: random values on the integer lattice, interpolated with zero slope at its points.
class ValueNoise {
 public:
  explicit ValueNoise(std::uint64_t seed) : seed_(seed) {}

  double at(const Eigen::Vector3d& p) const {
    const Eigen::Array3d low = p.array().floor();
    const Eigen::Array3d t = p.array() - low, s = t * t * (3 - 2 * t);
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1;
      std::uint64_t hash = seed_;
      for (int axis = 0; axis < 3; ++axis) {
        const int upper = (corner >> axis) & 1;
        weight *= upper ? s[axis] : 1 - s[axis];
        const auto coordinate = static_cast<std::int64_t>(low[axis]) + upper;
        hash = RandomStream::mix(hash + 0x9e3779b97f4a7c15ULL + static_cast<std::uint64_t>(coordinate));
      }
      sum += weight * static_cast<double>(hash >> 11) * 0x1p-53;
    }
    return sum;
  }

 private:
  std::uint64_t seed_ = 0;
};

}  // namespace phiz
