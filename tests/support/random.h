#pragma once

#include <cstdint>
#include <string_view>

namespace phiz::test {

/// Small deterministic generator (SplitMix64): the same numbers on every machine and library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next();                      ///< 64 uniform bits
  std::uint64_t below(std::uint64_t limit);  ///< uniform in [0, limit); limit > 0
  double uniform();                          ///< uniform in [0, 1)
  double uniform(double low, double high);   ///< uniform in [low, high)
  double normal();                           ///< N(0, 1)

 private:
  std::uint64_t state_;
};

/// The generator of the running test. The main reseeds it before each test from $PHIZ_TEST_SEED (default 1)
/// and the test's full name, so that a test sees the same numbers alone, shuffled or in company.
Random& random();

/// The base seed, and the seed of one test ("Suite.Name").
std::uint64_t base_seed();
std::uint64_t seed_of_test(std::string_view full_name);

}  // namespace phiz::test
