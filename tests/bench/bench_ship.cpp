#include <fstream>
#include <iterator>
#include <sstream>

#include "tests/bench/bench_main.h"
#include "tests/bench/ship.h"

namespace phiz::bench {

std::string export_bytes(const ShipWorld& ship, const std::string& subject, const std::string& file,
                         std::vector<std::string> arguments) {
  const std::filesystem::path path = ship.world.scratch / file;
  std::vector<std::string> words = {"export", subject, "-o", path.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  const test::ProgramRun run = run_phiz(ship.store, words);
  if (run.exit_code != 0) throw std::runtime_error("export " + file + ": " + run.err);
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

namespace {

void measure_ship(const BenchWorld& world) {
  ShipWorld ship{world, world.scratch / "ship", {}};
  const FitRun everything = fit_everything(world, ship.store);
  for (const auto& [name, run] : everything.subjects) {
    if (!run.is_done) continue;
    std::istringstream in(read_object(ship.store, run.digests().at("subdivide/head.glb")));
    ship.subjects.push_back({name, read_head_asset(in)});
  }
  if (ship.subjects.empty()) throw std::runtime_error("nothing was fitted");
  if (!world.is_long && ship.subjects.size() > 3) {  // first, middle and last: the last is the real scan
    ship.subjects = {ship.subjects.front(), ship.subjects[ship.subjects.size() / 2], ship.subjects.back()};
    world.board.note("three subjects; all of them with --long");
  }
  measure_sizes(ship);
  measure_decoding(ship);
  measure_programs(ship);
  measure_damage(ship);
}

}  // namespace
}  // namespace phiz::bench

int main(int argc, char** argv) {
  return phiz::bench::run_area("ship", argc, argv, phiz::bench::measure_ship);
}
