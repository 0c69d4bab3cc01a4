// Flipped bits, full disks, and the tests that hold the promises at every operation.

#include <fmt/format.h>
#include <sys/mount.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "tests/bench/bench_store.h"
#include "tests/bench/tally.h"

namespace phiz::bench {
namespace {

namespace fs = std::filesystem;

std::string read_bytes(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<fs::path> list_store_files(const fs::path& store) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(store)) {
    if (entry.is_regular_file() && entry.file_size() > 0) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

void flip_bit(const fs::path& file, std::mt19937_64& random) {
  fs::permissions(file, fs::perms::owner_write, fs::perm_options::add);
  std::fstream stream(file, std::ios::binary | std::ios::in | std::ios::out);
  const auto place = static_cast<std::streamoff>(random() % fs::file_size(file));
  stream.seekg(place);
  const int byte = stream.get();
  stream.seekp(place);
  stream.put(static_cast<char>(byte ^ (1 << (random() % 8))));
}

/// A small tmpfs, unmounted at the end of its scope.
class SmallDisk {
 public:
  SmallDisk(const fs::path& folder, std::uint64_t bytes) : folder_(folder) {
    fs::create_directories(folder_);
    is_mounted_ = ::mount("tmpfs", folder_.c_str(), "tmpfs", 0, fmt::format("size={}", bytes).c_str()) == 0;
    error_ = errno;
  }
  ~SmallDisk() {
    if (is_mounted_) ::umount(folder_.c_str());
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  bool is_mounted() const { return is_mounted_; }
  std::string error() const { return std::strerror(error_); }
  void grow() { ::mount("tmpfs", folder_.c_str(), "tmpfs", MS_REMOUNT, "size=256m"); }

 private:
  fs::path folder_;
  bool is_mounted_ = false;
  int error_ = 0;
};

/// How a fit on a disk of that size ended: the exit code, the stage that failed, and whether all was well
/// after.
struct FullRun {
  int code = 0;
  std::string stage;
  bool is_resumed = true;
};

FullRun fit_on_disk_of(const StoreBench& bench, const fs::path& scan, std::uint64_t bytes,
                       const std::string& outputs) {
  SmallDisk disk(bench.scratch / "disk", bytes);
  const fs::path store = bench.scratch / "disk" / "store";
  FullRun run;
  const auto fit = run_phiz(store, {"fit", "--json", "-j", "1", scan.string()});
  run.code = fit.exit_code;
  std::istringstream lines(fit.out);
  for (std::string line; std::getline(lines, line);) {
    const auto object = nlohmann::json::parse(line, nullptr, false);
    if (object.is_object() && object.value("type", "") == "error") run.stage = object.value("stage", "");
  }
  disk.grow();
  if (fs::exists(store / "phiz-store.json"))
    run.is_resumed = run_phiz(store, {"store", "verify"}).exit_code == 0;
  run.is_resumed = run.is_resumed &&
                   run_phiz(store, {"fit", "-q", "-j", "1", scan.string()}).exit_code == 0 &&
                   list_outputs(store) == outputs;
  return run;
}

}  // namespace

void measure_rot(const StoreBench& bench) {
  const int flips = bench.is_long ? 400 : 25;
  const fs::path scan = make_small_scans(bench, 1).front(), whole = bench.scratch / "whole";
  if (run_phiz(whole, {"fit", "-q", scan.string()}).exit_code != 0)
    throw std::runtime_error("phiz fit failed");
  const std::string outputs = list_outputs(whole), subject = scan.stem();
  const fs::path head = bench.scratch / "head.glb";
  run_phiz(whole, {"export", subject, "-o", head.string()});
  const std::string good = read_bytes(head);
  Tally tally(bench.record, "rot");
  while (tally.pieces() < flips) {
    std::mt19937_64 random(1000 + static_cast<std::uint64_t>(tally.pieces()));
    const fs::path store = bench.scratch / "rotten";
    fs::remove_all(store);
    fs::copy(whole, store, fs::copy_options::recursive);
    const std::vector<fs::path> files = list_store_files(store);
    flip_bit(files[random() % files.size()], random);
    fs::remove(head);
    const auto exported = run_phiz(store, {"export", subject, "-o", head.string()});
    const fs::path copy = bench.scratch / "rotten2";
    fs::remove_all(copy);
    fs::copy(store, copy, fs::copy_options::recursive);
    // A file that the export has set aside is found by its absence.
    const int found = run_phiz(copy, {"store", "verify"}).exit_code == 12 || exported.exit_code != 0;
    const int delivered = exported.exit_code == 0 && read_bytes(head) != good;
    run_phiz(store, {"store", "verify", "--repair"});
    run_phiz(store, {"fit", "-q", scan.string()});  // a record of a subject is made by the next fit
    const int repaired =
        list_outputs(store) == outputs && run_phiz(store, {"store", "verify"}).exit_code == 0;
    tally.add({{"found", found}, {"repaired", repaired}, {"delivered", delivered}});
  }
  const int count = tally.pieces();
  bench.board.note(fmt::format("{} single flipped bits anywhere in a store", count));
  bench.board.add({"found by verify", 100.0 * tally["found"] / count, "%", at_least(100)});
  bench.board.add({"repaired by recomputation", 100.0 * tally["repaired"] / count, "%", at_least(100)});
  bench.board.add({"delivered", static_cast<double>(tally["delivered"]), "", at_most(0)});
}

void measure_full_disk(const StoreBench& bench) {
  const SmallDisk probe(bench.scratch / "probe", 1 << 20);
  if (!probe.is_mounted())
    return bench.board.note("full disk: skipped, no tmpfs can be mounted here: " + probe.error());
  const fs::path scan = make_small_scans(bench, 1).front(), whole = bench.scratch / "roomy";
  if (run_phiz(whole, {"fit", "-q", scan.string()}).exit_code != 0)
    throw std::runtime_error("phiz fit failed");
  const std::string outputs = list_outputs(whole);
  std::uint64_t used = 0;
  for (const fs::path& file : list_store_files(whole)) used += (fs::file_size(file) + 4095) / 4096 * 4096;

  std::map<std::string, int> stages;
  int runs = 0, wrong_codes = 0, not_resumed = 0;
  // Ever finer steps of size, until each stage has met its end once.
  for (std::uint64_t steps = 8; steps <= 512 && stages.size() < 5; steps *= 2) {
    for (std::uint64_t i = 1; i < steps && stages.size() < 5; i += steps == 8 ? 1 : 2) {
      const std::uint64_t bytes = std::max<std::uint64_t>(4096, used * i / steps / 4096 * 4096);
      const FullRun run = fit_on_disk_of(bench, scan, bytes, outputs);
      ++runs;
      wrong_codes += run.code != 13 && run.code != 0;
      not_resumed += !run.is_resumed;
      if (run.code == 13 && !run.stage.empty()) ++stages[run.stage];
    }
  }
  std::string names;
  for (const auto& [stage, count] : stages) names += fmt::format(" {}", stage);
  bench.board.note(fmt::format("full disk: {} tmpfs sizes below {} kB; full at{}", runs, used / 1000, names));
  bench.board.add({"stages at which the disk was full", static_cast<double>(stages.size()), "", at_least(5)});
  bench.board.add({"exit codes other than 13", static_cast<double>(wrong_codes), "", at_most(0)});
  bench.board.add({"stores not valid or not resumed", static_cast<double>(not_resumed), "", at_most(0)});
}

void measure_tests(const StoreBench& bench) {
  struct Suite {
    std::string what, program, filter;
  };
  const std::vector<Suite> suites = {
      {"store: fail at operation n, every n; power cuts", "store/store_test", "StoreFaults.*:Collect.*"},
      {"program: fail at operation n, every n", "orchestrator/orchestrator_test", "FitFaults.*"}};
  for (const Suite& suite : suites) {
    const fs::path program = bench.build_folder / "tests" / suite.program;
    if (!fs::exists(program)) {
      bench.board.add_missing(suite.what, at_most(0), program.filename().string() + " is not built");
      continue;
    }
    const auto run = test::run_program({program.string(), "--gtest_filter=" + suite.filter});
    const bool has_run = run.out.find("[  PASSED  ]") != std::string::npos;
    int violations = has_run ? 0 : 1;
    for (std::size_t at = run.out.find(": Failure\n"); at != std::string::npos;
         at = run.out.find(": Failure\n", at + 1))
      ++violations;
    bench.board.add({suite.what + ": violations", static_cast<double>(violations), "", at_most(0)});
  }
}

}  // namespace phiz::bench
