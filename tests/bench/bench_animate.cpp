#include <time.h>

#include <algorithm>
#include <stdexcept>

#include "tests/bench/animate.h"
#include "tests/bench/bench_main.h"

namespace phiz::bench {
namespace {

constexpr std::size_t kSubjects = 3;

double seconds_now() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

std::vector<AnimateSubject> fit_subjects(const BenchWorld& bench, const std::filesystem::path& store) {
  std::vector<std::filesystem::path> scans;
  for (std::size_t i = 0; i < std::min(kSubjects, bench.data.subjects.size()); ++i)
    scans.push_back(bench.data.subjects[i].scan);
  const FitRun fits = run_fit(scans, {.store = store, .threads = 0, .arguments = {}, .kill_after_s = {}});
  std::vector<AnimateSubject> subjects;
  for (const auto& [name, run] : fits.subjects) {
    if (!run.is_done) throw std::runtime_error(name + " was not fitted: " + run.error);
    const FittedHead fitted = load_fitted(store, run, bench.head);
    subjects.push_back({name, to_float(fitted.control), fitted.displacements_mm});
  }
  if (subjects.empty()) throw std::runtime_error("no subject was fitted");
  return subjects;
}

void measure_animate(const BenchWorld& bench) {
  const std::filesystem::path store = bench.scratch / "animate";
  const AnimateWorld world{bench, store, fit_subjects(bench, store),
                           std::make_shared<SurfacePlan>(bench.head.hierarchy)};
  measure_living_surface(world);
  measure_skin(world);
}

}  // namespace

RunTimes measure_times(int runs, const std::function<void()>& work) {
  work();
  std::vector<double> times;
  for (int run = 0; run < runs; ++run) {
    const double start = seconds_now();
    work();
    times.push_back(seconds_now() - start);
  }
  return {*std::min_element(times.begin(), times.end()), median(times)};
}

double measure_bandwidth() {
  constexpr std::size_t kFloats = 12u << 20;
  std::vector<float> a(kFloats, 0.0f), b(kFloats, 1.0f), c(kFloats, 2.0f);
  float s = 0.5f;
  const RunTimes times = measure_times(9, [&] {
    for (std::size_t i = 0; i < kFloats; ++i) a[i] = b[i] + s * c[i];
    s += a[kFloats / 2] * 1e-9f;
  });
  return 3.0 * sizeof(float) * static_cast<double>(kFloats) / times.best_s;
}

}  // namespace phiz::bench

int main(int argc, char** argv) {
  return phiz::bench::run_area("animate", argc, argv, phiz::bench::measure_animate);
}
