#include "tests/support/random.h"

#include <cmath>
#include <cstdlib>

namespace phiz::test {

std::uint64_t Random::next() {
  std::uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

std::uint64_t Random::below(std::uint64_t limit) {
  const std::uint64_t reject_from = UINT64_MAX - UINT64_MAX % limit;
  std::uint64_t value = next();
  while (value >= reject_from) value = next();
  return value % limit;
}

double Random::uniform() {
  return static_cast<double>(next() >> 11) * 0x1.0p-53;
}

double Random::uniform(double low, double high) {
  return low + (high - low) * uniform();
}

double Random::normal() {
  constexpr double kTwoPi = 6.283185307179586476925;
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
  return radius * std::cos(kTwoPi * uniform());
}

Random& random() {
  static Random generator(base_seed());
  return generator;
}

std::uint64_t base_seed() {
  const char* text = std::getenv("PHIZ_TEST_SEED");
  return text && *text ? std::strtoull(text, nullptr, 10) : 1;
}

std::uint64_t seed_of_test(std::string_view full_name) {
  std::uint64_t hash = 0xCBF29CE484222325u;  // FNV-1a
  for (const char c : full_name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3u;
  return Random(hash ^ base_seed()).next();
}

}  // namespace phiz::test
