// Several real processes on one store: killed at any instant, side by side, beside a collector.

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <random>
#include <set>
#include <sstream>
#include <thread>

#include "tests/bench/bench_store.h"
#include "tests/bench/tally.h"

namespace phiz::bench {
namespace {

namespace fs = std::filesystem;

/// A list of the scans, for --list.
fs::path write_list(const StoreBench& bench, const std::vector<fs::path>& scans, const std::string& name) {
  const fs::path file = bench.scratch / name;
  std::ofstream out(file);
  out << "scan\n";
  for (const fs::path& scan : scans) out << scan.string() << "\n";
  return file;
}

std::set<std::string> list_files(const fs::path& folder) {
  std::set<std::string> names;
  if (!fs::exists(folder)) return names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    if (!name.starts_with(".tmp-")) names.insert(name);
  }
  return names;
}

test::ProgramRun fit_list(const fs::path& store, const fs::path& list, std::optional<double> kill_after_s) {
  test::ProgramOptions options;
  options.kill_after_s = kill_after_s;
  return test::run_program({test::phiz_program().string(), "fit", "--list", list.string(), "-q", "-j", "1",
                            "--store", store.string()},
                           options);
}

/// What went wrong, by kind.
struct Toll {
  int kills = 0, corrupt = 0, lost = 0, failed = 0, stale = 0, different = 0;
};

/// Four processes at once, each killed at a random instant; then what must hold. How many of them came to
/// their end.
int kill_four(const fs::path& store, const fs::path& list, double horizon_s, std::mt19937_64& random,
              std::set<std::string>& seen, Toll& toll) {
  std::vector<std::thread> threads;
  std::atomic<int> kills = 0, failed = 0;
  for (int i = 0; i < 4; ++i) {
    const double after_s = horizon_s * static_cast<double>(random() % 10'000) / 10'000;
    threads.emplace_back([&, after_s] {
      const int code = fit_list(store, list, after_s).exit_code;
      if (code == 137) ++kills;
      if (code != 137 && code != 0) ++failed;
    });
  }
  for (std::thread& thread : threads) thread.join();
  toll.kills += kills;
  toll.failed += failed;
  if (!fs::exists(store / "phiz-store.json")) return 4 - kills;
  if (run_phiz(store, {"store", "verify", "-q"}).exit_code != 0) ++toll.corrupt;
  const std::set<std::string> now = list_files(store / "results");
  for (const std::string& result : seen) toll.lost += !now.contains(result);
  seen.insert(now.begin(), now.end());
  return 4 - kills;
}

}  // namespace

std::vector<fs::path> make_small_scans(const StoreBench& bench, int count) {
  const fs::path folder = bench.scratch / "small";
  if (!fs::exists(folder / fmt::format("scans/synth{:03}.ply", count))) {
    const auto made = test::run_program({test::phiz_program().string(), "synth", "-o", folder.string(), "-q",
                                         "--points", "40000", "--subjects", std::to_string(count)});
    if (made.exit_code != 0) throw std::runtime_error("phiz synth: " + made.err);
  }
  std::vector<fs::path> scans;
  for (int i = 1; i <= count; ++i) scans.push_back(folder / fmt::format("scans/synth{:03}.ply", i));
  return scans;
}

std::string list_outputs(const fs::path& store) {
  std::istringstream lines(run_phiz(store, {"store", "ls"}).out);
  std::set<std::string> sorted;
  for (std::string line; std::getline(lines, line);) sorted.insert(line);
  std::string text;
  for (const std::string& line : sorted) text += line + "\n";
  return text;
}

void measure_kills(const StoreBench& bench) {
  const int wanted = bench.is_long ? 1000 : 24;
  Tally tally(bench.record, "kills");
  const fs::path list = write_list(bench, make_small_scans(bench, 3), "kills.csv");
  const fs::path whole = bench.scratch / "undisturbed";
  const auto undisturbed = fit_list(whole, list, {});
  const std::string outputs = list_outputs(whole);
  if (undisturbed.exit_code != 0 || outputs.empty())
    return bench.board.add_missing("kills", at_least(wanted), "phiz fit: " + undisturbed.err);
  // Instants within what is left to do, however busy the machine is.
  double horizon_s = undisturbed.seconds;
  while (tally["kills"] < wanted) {
    std::mt19937_64 random(8 + static_cast<std::uint64_t>(tally.pieces()));
    Toll toll;
    const fs::path store = bench.scratch / fmt::format("killed{}", tally.pieces());
    std::set<std::string> seen;
    for (int i = 0; i < 6 && tally["kills"] + toll.kills < wanted; ++i) {
      const int ended = kill_four(store, list, horizon_s, random, seen, toll);
      horizon_s = std::clamp(horizon_s * (ended > 0 ? 0.7 : 1.2), 0.2, 60.0);
      if (ended > 0) break;  // all is finished
    }
    toll.failed += fit_list(store, list, {}).exit_code != 0;
    toll.different += list_outputs(store) != outputs;
    toll.stale += static_cast<int>(list_files(store / "leases").size());
    toll.corrupt += run_phiz(store, {"store", "verify"}).exit_code != 0;
    fs::remove_all(store);
    tally.add({{"kills", toll.kills},
               {"corrupt", toll.corrupt},
               {"lost", toll.lost},
               {"failed", toll.failed},
               {"stale", toll.stale},
               {"different", toll.different}});
  }
  bench.board.note("kill -9 of 4 processes on one store at random instants, 3 small subjects, then resumed");
  const auto add = [&](const std::string& what, const std::string& name, const Bar& bar) {
    bench.board.add({what, static_cast<double>(tally[name]), "", bar});
  };
  add("kills", "kills", at_least(wanted));
  add("corrupt after a kill", "corrupt", at_most(0));
  add("lost results", "lost", at_most(0));
  add("runs that failed", "failed", at_most(0));
  add("stale locks", "stale", at_most(0));
  add("final outputs that differ", "different", at_most(0));
}

void measure_sharing(const StoreBench& bench) {
  const int count = bench.is_long ? 20 : 8;
  const fs::path list = write_list(bench, make_small_scans(bench, count), "sharing.csv");
  const fs::path store = bench.scratch / "sharing";
  std::vector<FitRun> runs(8);
  std::vector<std::thread> threads;
  for (FitRun& run : runs) {
    threads.emplace_back([&] { run = run_fit({}, {store, 1, {"--list", list.string()}, {}}); });
  }
  for (std::thread& thread : threads) thread.join();
  std::map<std::string, int> computed;
  int unfinished = 0;
  for (const FitRun& run : runs) {
    unfinished += run.program.exit_code != 0 || static_cast<int>(run.subjects.size()) != count;
    for (const auto& [name, subject] : run.subjects) {
      for (const auto& [stage, step] : subject.stages) computed[name + "/" + stage] += step.is_computed;
    }
  }
  const auto not_once =
      std::count_if(computed.begin(), computed.end(), [](const auto& entry) { return entry.second != 1; });
  bench.board.note(fmt::format("8 processes fit the same {} subjects", count));
  bench.board.add({"processes that did not end well", static_cast<double>(unfinished), "", at_most(0)});
  bench.board.add({"stages", static_cast<double>(computed.size()), "", at_least(5 * count)});
  bench.board.add({"stages not computed exactly once", static_cast<double>(not_once), "", at_most(0)});
}

void measure_collecting(const StoreBench& bench) {
  const int rounds = bench.is_long ? 100 : 10;
  const std::vector<fs::path> scans = make_small_scans(bench, 2);
  const fs::path store = bench.scratch / "collected";
  Tally tally(bench.record, "gc");
  while (tally.pieces() < rounds) {
    // Two settings in turn: what one round no longer needs the next one needs again.
    const std::vector<std::string> settings = {"--set",
                                               fmt::format("fit_global.rounds={}", 6 + tally.pieces() % 2)};
    int collected = 0, failed = 0, missing = 0;
    std::atomic<bool> is_running = true;
    std::thread collector([&] {
      while (is_running) {
        const auto gc = run_phiz(store, {"store", "gc", "--older-than", "0s"});
        collected += gc.exit_code == 0;
        failed += gc.exit_code != 0 && gc.exit_code != 10;  // 10: no store yet
      }
    });
    const FitRun first = run_fit(scans, {store, 1, settings, {}});
    const FitRun second = run_fit(scans, {store, 1, settings, {}});
    is_running = false;
    collector.join();
    failed += (first.program.exit_code != 0) + (second.program.exit_code != 0);
    for (const auto& [name, subject] : second.subjects) {
      for (const auto& [stage, step] : subject.stages) missing += step.is_computed;
    }
    missing += run_phiz(store, {"store", "verify"}).exit_code != 0;
    tally.add({{"collected", collected}, {"failed", failed}, {"missing", missing}});
  }
  bench.board.note(fmt::format("{} rounds of fits with changing settings beside gc --older-than 0s", rounds));
  bench.board.add({"collections", static_cast<double>(tally["collected"]), "", at_least(rounds)});
  bench.board.add({"runs and collections that failed", static_cast<double>(tally["failed"]), "", at_most(0)});
  bench.board.add({"needed things removed", static_cast<double>(tally["missing"]), "", at_most(0)});
}

}  // namespace phiz::bench
