#include <fstream>
#include <stdexcept>

#include "tests/bench/bench_main.h"
#include "tests/bench/fields.h"

namespace phiz::bench {

FieldsWorld make_fields_world(const BenchWorld& bench) {
  FieldsWorld world{bench, bench.scratch / "fields", bench.scratch / "rig", {}, {}};
  const std::string muscles = PHIZ_SOURCE_FOLDER "/samples/muscles";
  const test::ProgramRun made =
      run_phiz(world.store, {"fields", "muscles", "--from", muscles, "-o", world.rig_path.string()});
  if (made.exit_code != 0) throw std::runtime_error("phiz fields muscles: " + made.err);
  std::ifstream json(world.rig_path.string() + ".json"),
      exr(world.rig_path.string() + ".exr", std::ios::binary);
  world.rig = read_deformation(json, exr);
  world.fits = fit_everything(bench, world.store);
  return world;
}

NeutralSurface load_neutral(const FieldsWorld& world, const std::string& subject, const NeutralMaker& maker) {
  const FittedHead fitted = load_fitted(world.store, world.fits.subjects.at(subject), world.bench.head);
  return maker.make(fitted.control, fitted.displacements_mm);
}

namespace {

void measure_fields(const BenchWorld& bench) {
  const FieldsWorld world = make_fields_world(bench);
  measure_cascade_speed(world);
  measure_exactness(world);
  measure_retarget(world);
  measure_track(world);
  measure_learned_fields(world);
}

}  // namespace
}  // namespace phiz::bench

int main(int argc, char** argv) {
  return phiz::bench::run_area("fields", argc, argv, phiz::bench::measure_fields);
}
