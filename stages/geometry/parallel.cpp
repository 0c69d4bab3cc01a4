#include "stages/geometry/parallel.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "stages/geometry/error.h"

namespace phiz {

void parallel_for(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body) {
  CONTRACT(grain > 0);
  const std::size_t chunks = count == 0 ? 0 : (count - 1) / grain + 1;
  if (chunks == 1) return body(0, count);
  tbb::parallel_for(std::size_t{0}, chunks,
                    [&](std::size_t chunk) { body(chunk * grain, std::min(count, (chunk + 1) * grain)); });
}

void with_threads(int threads, const std::function<void()>& work) {
  CONTRACT(threads >= 0);
  tbb::task_arena arena(threads == 0 ? tbb::task_arena::automatic : threads);
  arena.execute(work);
}

}  // namespace phiz
