#include "tests/bench/bench_main.h"

int main(int argc, char** argv) {
  return phiz::bench::run_area("fit", argc, argv, [](const phiz::bench::BenchWorld& world) {
    using namespace phiz::bench;
    measure_runs(world);
    const std::filesystem::path store = world.scratch / "all";
    const FitRun everything = fit_everything(world, store);
    measure_turned(world, store, everything);
    measure_accuracy(world, store, everything);
    measure_silhouettes(world);
  });
}
