#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tests/bench/bench_main.h"
#include "tests/bench/correspondence.h"
#include "tests/bench/surface_error.h"

namespace phiz::bench {
namespace {

constexpr double kSameMm = 0.0005;  // errors are recorded to three decimals

void check_template(const BenchWorld& world) {
  const std::string head = std::getenv("PHIZ_TEMPLATE");  // set for every phiz of this run
  const test::ProgramRun run = test::run_program({test::phiz_program().string(), "template", "check", head});
  std::istringstream lines(run.out + run.err);
  for (std::string line; std::getline(lines, line);) world.board.note(line);
  world.board.add({"phiz template check: exit code", static_cast<double>(run.exit_code), "", at_most(0)});
}

/// The smallest level-4 error recorded with any earlier head on these subjects; see README.md.
std::optional<double> find_best_recorded(const std::string& subjects) {
  std::ifstream in(std::filesystem::path(PHIZ_SOURCE_FOLDER) / "tests" / "bench" / "head_history.csv");
  std::optional<double> best;
  for (std::string line; std::getline(in, line);) {
    std::istringstream fields(line);
    std::string names, error;
    if (!std::getline(fields, names, ',') || !std::getline(fields, error, ',') || names != subjects) continue;
    const double value = std::stod(error);
    best = best ? std::min(*best, value) : value;
  }
  return best;
}

struct FittedSubjects {
  std::vector<Placed> placed;
  std::vector<double> skin;  ///< true skin to level 4, mm
  std::string names;         ///< joined by spaces
};

FittedSubjects fit_subjects(const BenchWorld& world) {
  const std::filesystem::path store = world.scratch / "head";
  const FitRun everything = fit_everything(world, store);
  FittedSubjects result;
  for (const BenchSubject& subject : world.data.subjects) {
    const auto run = everything.subjects.find(subject.name);
    if (subject.truth.empty() || run == everything.subjects.end() || !run->second.is_done) continue;
    const FittedHead fitted = load_fitted(store, run->second, world.head);
    const Eigen::Matrix4d truth_from_head = subject.scan_from_truth.inverse() * fitted.scan_from_head;
    const TruthScene scene = load_truth_scene(subject);
    Placed placed{
        subject.name, scene.truth, {}, transform(truth_from_head, evaluate_finest(fitted, world.head))};
    placed.vertices.assign(placed.finest.begin(),
                           placed.finest.begin() + world.head.hierarchy.vertex_count(kCorrespondenceLevel));
    const SurfaceIndex surface(to_float(placed.finest), world.head.hierarchy.triangles(kFinestLevel));
    const SkinErrors skin = measure_skin(subject, scene, world.data.labels, fitted, world.head, surface);
    result.skin.insert(result.skin.end(), skin.surface.begin(), skin.surface.end());
    result.names += (result.names.empty() ? "" : " ") + subject.name;
    result.placed.push_back(std::move(placed));
  }
  return result;
}

void report_correspondence(const BenchWorld& world, const std::vector<Placed>& placed) {
  const Correspondence error = measure_correspondence(placed, world.head, world.data.labels);
  const auto region = [&](const char* name) {
    return error.regions.contains(name) ? error.regions.at(name) : NAN;
  };
  world.board.note(fmt::format("{} ordered pairs, vertices of level {}", error.pairs, kCorrespondenceLevel));
  world.board.add({"same anatomy across subjects, narrow face", error.narrow_face, "mm", at_most(1.6)});
  world.board.add({"same anatomy, ears", region("ears"), "mm", at_most(3)});
  world.board.add({"same anatomy, lips", region("lips"), "mm", at_most(1.5)});
  world.board.add({"same anatomy, eyelids", region("eyelids"), "mm", at_most(1.5)});
}

void report_landmarks(const BenchWorld& world, const std::vector<Placed>& placed) {
  std::vector<double> errors;
  std::string worst_name;
  double worst = 0;
  for (const auto& [name, error] : measure_landmarks(placed, world.head, world.data.labels)) {
    errors.push_back(error);
    if (error > worst) {
      worst = error;
      worst_name = name;
    }
  }
  world.board.add({fmt::format("landmarks on the fitted subjects, mean of {}", errors.size()), mean(errors),
                   "mm", at_most(2.5)});
  world.board.add({"worst landmark on average (" + worst_name + ")", worst, "mm", at_most(5)});
}

void measure_head(const BenchWorld& world) {
  check_template(world);
  const FittedSubjects subjects = fit_subjects(world);
  report_correspondence(world, subjects.placed);
  report_landmarks(world, subjects.placed);
  const std::optional<double> best = find_best_recorded(subjects.names);
  if (!best) world.board.note("no earlier head is recorded for these subjects");
  world.board.add({"true skin to level 4, mean; bar: best of the earlier heads", mean(subjects.skin), "mm",
                   best ? at_most(*best + kSameMm) : Bar{}});
  world.board.note(
      fmt::format("for head_history.csv: {},{:.3f},<commit>", subjects.names, mean(subjects.skin)));
}

}  // namespace
}  // namespace phiz::bench

int main(int argc, char** argv) {
  return phiz::bench::run_area("head", argc, argv, phiz::bench::measure_head);
}
