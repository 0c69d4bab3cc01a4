#include <fmt/format.h>

#include <algorithm>
#include <random>
#include <stdexcept>

#include "tests/bench/areas.h"

namespace phiz::bench {
namespace {

constexpr int kTimedRuns = 5, kFewKills = 10, kManyKills = 50;
constexpr int kThreads = 2;
constexpr double kMebibyte = 1024.0 * 1024.0;

/// The first scan of about 300,000 points without triangles, as the timed one.
const BenchSubject& find_timed_subject(const BenchData& data) {
  for (const BenchSubject& subject : data.subjects) {
    if (!subject.has_triangles && subject.points >= 290'000 && subject.points <= 310'000) return subject;
  }
  throw std::runtime_error("subjects.json names no scan of 300,000 points");
}

std::filesystem::path new_store(const BenchWorld& world, const std::string& name) {
  const std::filesystem::path store = world.scratch / name;
  std::filesystem::remove_all(store);
  std::filesystem::create_directories(store.parent_path());
  return store;
}

void require_done(const FitRun& run, const BenchSubject& subject) {
  const auto found = run.subjects.find(subject.name);
  if (found != run.subjects.end() && found->second.is_done && run.program.exit_code == 0) return;
  throw std::runtime_error(subject.name + " was not fitted: " +
                           (found == run.subjects.end() ? run.program.err : found->second.error));
}

/// Cold runs of all stages, then the same command on finished work.
FitRun measure_cold(const BenchWorld& world, const BenchSubject& subject) {
  std::vector<double> seconds, processor_seconds, memory, local_and_global;
  FitRun run;
  for (int i = 0; i <= kTimedRuns; ++i) {  // the first one warms up
    run = run_fit({subject.scan}, {new_store(world, "cold"), kThreads, {}, {}});
    require_done(run, subject);
    if (i == 0) continue;
    const auto& stages = run.subjects.at(subject.name).stages;
    seconds.push_back(run.program.seconds);
    processor_seconds.push_back(run.program.processor_seconds);
    memory.push_back(static_cast<double>(run.program.peak_memory_bytes) / kMebibyte);
    local_and_global.push_back(stages.at("fit_local").seconds + stages.at("fit_global").seconds);
  }
  world.board.note(fmt::format("{} ({} points), -j{}, medians of {} runs after one to warm up", subject.name,
                               subject.points, kThreads, kTimedRuns));
  world.board.add({"300,000 points to level 4, cold", median(seconds), "s", at_most(4)});
  world.board.add({"the same, best run", *std::min_element(seconds.begin(), seconds.end()), "s", {}});
  world.board.add(
      {"peak memory of it", *std::max_element(memory.begin(), memory.end()), "MiB", at_most(1024)});
  world.board.add({"of that, local and global fit", median(local_and_global), "s", at_most(1.2)});
  for (const auto& [stage, stage_run] : run.subjects.at(subject.name).stages) {
    world.board.add({"of that, " + stage + ", last run", stage_run.seconds, "s", {}});
  }
  std::vector<double> cached;
  for (int i = 0; i <= kTimedRuns; ++i) {
    const test::ProgramRun again = run_phiz(world.scratch / "cold", {"fit", subject.scan.string()});
    if (again.exit_code != 0) throw std::runtime_error("the cached run failed: " + again.err);
    if (i > 0) cached.push_back(1000 * again.seconds);
  }
  world.board.add({"the same command again, all cached", median(cached), "ms", at_most(50)});
  return run;
}

std::size_t count_differences(const SubjectRun& a, const SubjectRun& b) {
  const auto left = a.digests(), right = b.digests();
  std::size_t count = left.size() != right.size();
  for (const auto& [name, digest] : left) {
    const auto other = right.find(name);
    count += other == right.end() || other->second != digest;
  }
  return count;
}

void measure_equality(const BenchWorld& world, const BenchSubject& subject, const SubjectRun& reference) {
  std::size_t differences = 0;
  for (const int threads : {1, 2}) {
    const FitRun run = run_fit({subject.scan}, {new_store(world, "elsewhere/deep/store"), threads, {}, {}});
    require_done(run, subject);
    differences += count_differences(reference, run.subjects.at(subject.name));
  }
  world.board.add({fmt::format("outputs that differ at -j1, at -j2, in another folder (of {})",
                               reference.digests().size()),
                   static_cast<double>(differences), "outputs", at_most(0)});
}

/// Names of the stages whose results are in the store, by a dry run.
std::vector<std::string> list_finished(const std::filesystem::path& store, const BenchSubject& subject) {
  const FitRun preview = run_fit({subject.scan}, {store, kThreads, {"--dry-run"}, {}});
  std::vector<std::string> finished;
  const auto found = preview.subjects.find(subject.name);
  if (found == preview.subjects.end()) return finished;
  for (const auto& [name, stage] : found->second.stages) {
    if (!stage.digests.empty()) finished.push_back(name);
  }
  return finished;
}

bool has_checkpoint(const std::filesystem::path& store) {
  std::error_code error;
  for (std::filesystem::recursive_directory_iterator entry(store / "checkpoints", error), end;
       !error && entry != end; entry.increment(error)) {
    if (entry->path().filename() == "state") return true;
  }
  return false;
}

void measure_kills(const BenchWorld& world, const BenchSubject& subject, const FitRun& reference) {
  const int kills = world.is_long ? kManyKills : kFewKills;
  std::mt19937_64 random(20020501);
  std::size_t repeated = 0, differences = 0, lost_checkpoints = 0, checkpoints = 0, failures = 0;
  for (int kill = 0; kill < kills; ++kill) {
    const std::filesystem::path store = new_store(world, "killed");
    const double share = static_cast<double>(random() >> 11) * 0x1p-53;
    run_fit({subject.scan}, {store, kThreads, {}, share * reference.program.seconds});
    const std::vector<std::string> finished = list_finished(store, subject);
    const bool is_in_global = has_checkpoint(store);
    const FitRun rerun = run_fit({subject.scan}, {store, kThreads, {}, {}});
    const auto found = rerun.subjects.find(subject.name);
    if (rerun.program.exit_code != 0 || found == rerun.subjects.end()) {
      ++failures;
      continue;
    }
    for (const std::string& stage : finished) repeated += found->second.stages.at(stage).is_computed;
    checkpoints += is_in_global;
    lost_checkpoints += is_in_global && !(found->second.stages.at("fit_global").first_fraction > 0);
    differences += count_differences(reference.subjects.at(subject.name), found->second);
  }
  world.board.note(
      fmt::format("kill -9 at {} random instants, rerun; {} fell behind a checkpoint of the global fit",
                  kills, checkpoints));
  world.board.add({"reruns that failed", static_cast<double>(failures), "runs", at_most(0)});
  world.board.add({"finished stages computed again", static_cast<double>(repeated), "stages", at_most(0)});
  world.board.add(
      {"global fits that left their checkpoint", static_cast<double>(lost_checkpoints), "fits", at_most(0)});
  world.board.add({"outputs that differ from an uninterrupted run", static_cast<double>(differences),
                   "outputs", at_most(0)});
}

}  // namespace

void measure_runs(const BenchWorld& world) {
  const BenchSubject& subject = find_timed_subject(world.data);
  const FitRun reference = measure_cold(world, subject);
  measure_equality(world, subject, reference.subjects.at(subject.name));
  measure_kills(world, subject, reference);
}

FitRun fit_everything(const BenchWorld& world, const std::filesystem::path& store) {
  std::vector<std::filesystem::path> scans;
  for (const BenchSubject& subject : world.data.subjects) scans.push_back(subject.scan);
  FitRun run = run_fit(scans, {store, 0, {}, {}});
  int done = 0;
  for (const BenchSubject& subject : world.data.subjects) {
    const auto found = run.subjects.find(subject.name);
    const bool is_done = found != run.subjects.end() && found->second.is_done;
    done += is_done;
    if (!is_done) {
      world.board.note(subject.name + ": " +
                       (found == run.subjects.end() ? run.program.err : found->second.error));
    }
  }
  world.board.add({fmt::format("scans fitted without any option (of {})", scans.size()),
                   100.0 * done / static_cast<double>(scans.size()), "%", at_least(100)});
  world.board.add({"exit code of that command", static_cast<double>(run.program.exit_code), "", at_most(0)});
  return run;
}

}  // namespace phiz::bench
