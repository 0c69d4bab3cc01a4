#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>

namespace phiz {

/// SplitMix64 (Steele, Lea, Flood 2014). Streams are named by numbers (seed, view, ray ...), so that a ray's
/// numbers do not depend on who computes it and when.
class RandomStream {
 public:
  RandomStream(std::initializer_list<std::uint64_t> names) {
    for (const std::uint64_t name : names) state_ = mix(state_ + kStep) ^ mix(name + kStep);
  }

  std::uint64_t next() { return mix(state_ += kStep); }
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }  ///< [0,1)
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// N(0,1) by Box and Muller.
  double normal() {
    constexpr double kTwoPi = 6.283185307179586;
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));
    return radius * std::cos(kTwoPi * uniform());
  }

  static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }

 private:
  static constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15ULL;
  std::uint64_t state_ = 0;
};

}  // namespace phiz
