#include <fmt/format.h>

#include <cstring>
#include <random>

#include "tests/bench/animate.h"

namespace phiz::bench {
namespace {

constexpr int kEdits = 10'000;

/// All control vertices a little away from where they were.
std::vector<Eigen::Vector3f> shaken(const AnimateSubject& subject) {
  std::mt19937 generator(7);
  std::vector<Eigen::Vector3f> control = subject.control;
  for (Eigen::Vector3f& p : control)
    for (int i = 0; i < 3; ++i) p[i] += static_cast<float>(generator() % 1000) * 1e-4f;
  return control;
}

void measure_whole(const AnimateWorld& world, LivingSurface& surface, double bandwidth) {
  const auto& subject = world.subjects.front();
  const std::vector<Eigen::Vector3f> poses[2] = {subject.control, shaken(subject)};
  const double bars_ms[] = {0, 0, 0.4, 2, 9};
  int turn = 0;
  for (int level = 2; level <= kFinestLevel; ++level) {
    const RunTimes times = measure_times(41, [&] { surface.evaluate(poses[++turn % 2], level); });
    const std::string name = fmt::format("level {} ({} vertices), all control vertices moved", level,
                                         world.plan->vertex_count(level));
    const auto bytes = static_cast<double>(surface.bytes_touched(level));
    world.bench.board.add({name, 1e3 * times.median_s, "ms", at_most(bars_ms[level])});
    world.bench.board.add({name + ", fastest run", 1e3 * times.best_s, "ms", {}});
    world.bench.board.add({fmt::format("level {}: bytes touched", level), bytes / 1e6, "MB", {}});
    world.bench.board.add({fmt::format("level {}: share of memory bandwidth", level),
                           100 * bytes / times.median_s / bandwidth,
                           "%",
                           {}});
  }
}

void measure_one_vertex(const AnimateWorld& world, LivingSurface& surface) {
  const auto& control = world.subjects.front().control;
  surface.evaluate(control, 2);
  std::vector<double> times;
  double computed = 0;
  for (int v = 0; v < static_cast<int>(control.size()); ++v) {
    const Eigen::Vector3f moved = control[v] + Eigen::Vector3f(0.1f, 0, 0);
    const RunTimes run = measure_times(5, [&] {
      surface.move(v, moved);
      surface.refresh(2);
    });
    times.push_back(run.median_s);
    computed += surface.updated_count();
    surface.move(v, control[v]);
    surface.refresh(2);
  }
  Board& board = world.bench.board;
  board.add({"one control vertex moved, level 2, mean of all", 1e6 * mean(times), "us", at_most(25)});
  board.add({"of those the slowest 1 %", 1e6 * quantile(times, 0.99), "us", {}});
  board.add({"vertices computed for one, mean", computed / static_cast<double>(times.size()), "", {}});
}

/// Random edits of one to ten vertices: every level compared with a whole evaluation, bit for bit.
void measure_agreement(const AnimateWorld& world) {
  const auto& subject = world.subjects.front();
  LivingSurface local(world.plan, subject.displacements_mm), whole(world.plan, subject.displacements_mm);
  std::vector<Eigen::Vector3f> control = subject.control;
  local.evaluate(control, kFinestLevel);
  std::mt19937 generator(11);
  int differing = 0;
  for (int edit = 0; edit < kEdits; ++edit) {
    // All levels lie in one array. The finest is compared after every tenth edit (it sees the nine before),
    // the first three after every edit.
    const int level = edit % 10 == 9 || world.bench.is_long ? kFinestLevel : 2;
    for (unsigned i = 0; i <= generator() % 10 * (edit % 2); ++i) {
      const int v = static_cast<int>(generator() % control.size());
      for (int c = 0; c < 3; ++c) control[v][c] += (static_cast<float>(generator() % 2001) - 1000) * 1e-3f;
      local.move(v, control[v]);
    }
    local.refresh(kFinestLevel);
    whole.evaluate(control, level);
    const std::span<const Point4> expected = whole.positions();
    differing += std::memcmp(local.positions().data(), expected.data(), expected.size_bytes()) != 0;
  }
  world.bench.board.add(
      {fmt::format("local and whole evaluation differ, of {} random edits, all levels", kEdits),
       static_cast<double>(differing), "", at_most(0)});
}

}  // namespace

void measure_living_surface(const AnimateWorld& world) {
  Board& board = world.bench.board;
  board.note("surface of subject " + world.subjects.front().name + ", one thread, processor time");
  const double bandwidth = measure_bandwidth();
  board.add({"memory bandwidth of one thread, triad", bandwidth / 1e9, "GB/s", {}});
  LivingSurface surface(world.plan, world.subjects.front().displacements_mm);
  measure_whole(world, surface, bandwidth);
  measure_one_vertex(world, surface);
  measure_agreement(world);
}

}  // namespace phiz::bench
