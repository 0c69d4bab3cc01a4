#pragma once

#include <vector>

namespace phiz {

template <class T, class Body>
T parallel_sum(std::size_t count, std::size_t grain, T zero, const Body& body) {
  std::vector<T> partials(count == 0 ? 0 : (count - 1) / grain + 1, zero);
  parallel_for(count, grain, [&](std::size_t begin, std::size_t end) { partials[begin / grain] = body(begin, end); });
  T total = zero;
  for (const T& partial : partials) total += partial;
  return total;
}

}  // namespace phiz
