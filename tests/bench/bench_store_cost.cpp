// What the store and the orchestrator cost beside the work itself.

#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <fstream>

#include "orchestrator/pipeline.h"
#include "orchestrator/run.h"
#include "store/store.h"
#include "tests/bench/bench_store.h"

namespace phiz::bench {
namespace {

namespace fs = std::filesystem;

double seconds_of(const std::function<void()>& call) {
  const auto begin = std::chrono::steady_clock::now();
  call();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

std::string noise(std::size_t bytes, std::uint64_t seed) {
  std::string text(bytes, '\0');
  for (char& c : text) {
    seed = seed * 6364136223846793005ULL + 1442695040888963407ULL;
    c = static_cast<char>(seed >> 56);
  }
  return text;
}

class NoReport final : public Reporter {
 public:
  void begin(std::size_t) override {}
  void step_started(const StepPlace&, const std::string&) override {}
  void step_progress(const StepPlace&, double, std::optional<double>) override {}
  void step_finished(const StepPlace&, const StepOutcome&) override {}
  void note(const StepPlace&, const std::string&) override {}
  void warning(const StepPlace&, const std::string&) override {}
  void failure(const StepPlace&, const Failure&) override {}
  void subject_finished(const SubjectOutcome&) override {}
};

/// Five tasks in a chain that do nothing.
std::vector<Task> make_idle_tasks() {
  std::vector<Task> tasks;
  for (int i = 0; i < 5; ++i) {
    Task task;
    task.name = fmt::format("idle{}", i);
    task.inputs = {i == 0 ? scan_input()
                          : output_of(fmt::format("idle{}", i - 1), fmt::format("out{}", i - 1))};
    const std::string output = fmt::format("out{}", i), input = task.inputs[0].name;
    task.outputs = {output};
    task.run = [output, input](TaskContext& context) {
      context.write_output(output, context.input_digest(input).hex());
    };
    tasks.push_back(task);
  }
  return tasks;
}

}  // namespace

void measure_write_path(const StoreBench& bench) {
  constexpr int kFiles = 16;
  constexpr std::size_t kBytes = 8 << 20;
  const fs::path folder = bench.scratch / "write";
  std::vector<double> ours, theirs, ratios;
  for (int round = 0; round < 6; ++round) {
    fs::remove_all(folder);
    fs::create_directories(folder / "copies");
    CommitRequest request;
    request.result.key_text.add("stage", "name", "write");
    for (int i = 0; i < kFiles; ++i) {
      const std::string name = fmt::format("file{:02}", i);
      request.outputs[name] = noise(kBytes, static_cast<std::uint64_t>(100 * round + i + 1));
      std::ofstream(folder / name, std::ios::binary) << request.outputs[name];
    }
    const std::string command = fmt::format("sync && cd '{}' && exec 9<file00", folder.string());
    if (std::system(command.c_str()) != 0) throw std::runtime_error("sync failed");
    const Store store = Store::open_or_create(real_file_system(), folder / "store");
    const double store_s = seconds_of([&] { store.commit(std::move(request)); });
    const std::string shell = fmt::format(
        "cd '{}' && sha256sum file?? > sums && cp file?? copies && sync copies/* copies", folder.string());
    const double shell_s = seconds_of([&] {
      if (std::system(shell.c_str()) != 0) throw std::runtime_error("sha256sum, cp or sync failed");
    });
    if (round == 0) continue;
    ours.push_back(store_s);
    theirs.push_back(shell_s);
    ratios.push_back(store_s / shell_s);
  }
  fs::remove_all(folder);
  bench.board.note("16 files of 8 MiB, one commit against sha256sum + cp + sync of the same bytes");
  bench.board.add({"commit", median(ours), "s", {}});
  bench.board.add({"sha256sum + cp + sync", median(theirs), "s", {}});
  bench.board.add({"store write path over sha256sum + cp + sync", median(ratios), "x", at_most(1.15)});
}

void measure_overhead(const StoreBench& bench) {
  // On a disk in memory where there is one: the orchestrator's share, not that of the disk's syncs.
  const bool has_memory_disk = fs::is_directory("/dev/shm");
  std::string name =
      has_memory_disk ? "/dev/shm/phiz-bench-XXXXXX" : (bench.scratch / "idle-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder: " + name);
  const fs::path folder = name;
  constexpr int kSubjects = 200;
  std::vector<SubjectJob> jobs;
  for (int i = 0; i < kSubjects; ++i) {
    std::ofstream(folder / fmt::format("s{}.xyz", i)) << i;
    jobs.push_back({fmt::format("s{}", i), folder / fmt::format("s{}.xyz", i), {}});
  }
  const Pipeline pipeline(make_idle_tasks());
  const TemplateFiles head;
  NoReport reporter;
  const StopFlag stop;
  RunOptions options;
  options.threads = 1;
  std::vector<double> computed_ms, kept_ms;
  for (int round = 0; round < 6; ++round) {
    const Store store = Store::open_or_create(real_file_system(), folder / fmt::format("store{}", round));
    LeaseTable leases(store, real_processes());
    for (std::vector<double>* times : {&computed_ms, &kept_ms}) {
      const double seconds = seconds_of([&] {
        run_subjects(jobs, options, {store, leases, pipeline, head, reporter, stop});
      });
      if (round > 0) times->push_back(1e3 * seconds / (kSubjects * 5));
    }
  }
  fs::remove_all(folder);
  bench.board.note(std::string("five tasks that do nothing, 200 subjects, one thread, store ") +
                   (has_memory_disk ? "in memory" : "on disk, syncs included"));
  bench.board.add({"orchestrator overhead, a computed task", median(computed_ms), "ms", at_most(1)});
  bench.board.add({"orchestrator overhead, a kept task", median(kept_ms), "ms", at_most(1)});
}

}  // namespace phiz::bench
