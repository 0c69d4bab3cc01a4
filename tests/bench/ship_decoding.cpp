#include <time.h>

#include <fstream>
#include <iterator>
#include <sstream>

#include "formats/error.h"
#include "stages/geometry/parallel.h"
#include "stages/subdivide/subdivide.h"
#include "tests/bench/ship.h"
#include "tests/support/random.h"

namespace phiz::bench {
namespace {

/// Processor time of this thread.
double milliseconds() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

std::string small_asset(const ShipWorld& ship) {
  std::ifstream in(ship.world.scratch / (ship.subjects.front().name + "_small.glb"), std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace

void measure_decoding(const ShipWorld& ship) {
  const std::string bytes = small_asset(ship);
  const HeadAsset& first = ship.subjects.front().head;
  const SubdivisionHierarchy hierarchy(first.triangles, static_cast<int>(first.positions.size()),
                                       kFinestLevel);
  std::vector<double> decode, whole;
  with_threads(1, [&] {
    for (int run = 0; run < 8; ++run) {
      const double begin = milliseconds();
      std::istringstream in(bytes);
      const HeadAsset head = read_head_asset(in);
      const double decoded = milliseconds() - begin;
      Positions control;
      for (const Eigen::Vector3f& p : head.positions) control.push_back(p.cast<double>());
      const Positions surface = evaluate_surface(hierarchy, control, head.displacements_mm, kFinestLevel);
      if (surface.empty()) throw std::runtime_error("nothing was evaluated");
      if (run == 0) continue;
      decode.push_back(decoded);
      whole.push_back(milliseconds() - begin);
    }
  });
  const double vertices = hierarchy.vertex_count(kFinestLevel);
  Board& board = ship.world.board;
  board.add({"decode level 4, one thread, its processor time, median", median(decode), "ms", {}});
  board.add(
      {"decode and evaluate level 4, scaled to 300,000 vertices, one thread, its processor time, median",
       median(whole) * 300000 / vertices, "ms", at_most(60)});
  board.add({"vertices of level 4", vertices, "", {}});
}

void measure_damage(const ShipWorld& ship) {
  const std::string bytes = small_asset(ship);
  test::Random dice(1);
  const int count = ship.world.is_long ? 100000 : 5000;
  int passed = 0;
  const auto attempt = [&](const std::string& damaged) {
    try {
      std::istringstream in(damaged);
      read_head_asset(in);
      passed += damaged != bytes;
    } catch (const FormatError&) {
    }
  };
  for (std::size_t length = 0; length < bytes.size(); length += length < 4096 || ship.world.is_long ? 1 : 97)
    attempt(bytes.substr(0, length));
  for (int i = 0; i < count; ++i) {
    std::string damaged = bytes;
    for (std::uint64_t edits = 1 + dice.below(4); edits > 0; --edits)
      damaged[dice.below(damaged.size())] ^= static_cast<char>(1 + dice.below(255));
    attempt(damaged);
  }
  ship.world.board.add({"damaged assets that were read all the same, of truncations and " +
                            std::to_string(count) + " corruptions",
                        static_cast<double>(passed), "", at_most(0)});
}

}  // namespace phiz::bench
