#pragma once

#include <cstddef>
#include <functional>

namespace phiz {

/// Calls body(begin, end) over [0, count) in chunks of exactly `grain` (the last may be shorter), on the threads of
/// the enclosing oneTBB arena. Chunk boundaries depend on count and grain alone, never on the number of threads:
/// a body that writes only its own chunk's results gives the same bytes at any thread count.
/// Exceptions of a body reach the caller.
void parallel_for(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

/// Ordered reduction: body(begin, end) returns a partial result per chunk; the partials are added left to right.
template <class T, class Body>
T parallel_sum(std::size_t count, std::size_t grain, T zero, const Body& body);

/// Runs `work` with at most `threads` threads (0: all the machine has).
void with_threads(int threads, const std::function<void()>& work);

}  // namespace phiz

#include "stages/geometry/parallel_sum.inl"
