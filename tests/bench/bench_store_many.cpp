// Ten thousand finished subjects, made through the store's own commit with the real tables of the stages
// (keys as phiz makes them, outputs of a few bytes), and looked at with the program.

#include <fmt/format.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "orchestrator/inputs.h"
#include "orchestrator/pipeline.h"
#include "orchestrator/tasks/tasks.h"
#include "store/store.h"
#include "tests/bench/bench_store.h"
#include "tests/bench/quick_disk.h"

namespace phiz::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kSubjects = 10'000;

class FinishedStore {
 public:
  FinishedStore(const fs::path& folder)
      : folder_(folder),
        pipeline_(list_task_tables()),
        head_(load_template(real_file_system(), fs::path(PHIZ_SOURCE_FOLDER) / "samples/generic_head")),
        store_(Store::open_or_create(disk_, folder / "store")) {}

  void make() {
    fs::create_directories(folder_ / "scans");
    std::ofstream list(folder_ / "subjects.csv");
    list << "subject,scan\n";
    for (int i = 0; i < kSubjects; ++i) {
      std::ofstream(scan(i)) << "0 0 " << i << "\n1 0 0\n0 1 0\n";
      list << fmt::format("head{:05},scans/{}\n", i, scan(i).filename().string());
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(200));  // files that are too new have no stamp
    for (int i = 0; i < kSubjects; ++i) finish(i);
  }

 private:
  fs::path scan(int i) const { return folder_ / "scans" / fmt::format("scan{:05}.xyz", i); }

  void finish(int i) const {
    const ScanInput scan_input = hash_scan(disk_, scan(i));
    SubjectRecord record{
        fmt::format("head{:05}", i), scan(i).string(), scan_input.digest, scan_input.size_bytes, {}, {}};
    record.scan_stamp = scan_input.stamp;
    std::map<std::string, Result> results;
    for (const Task* task : pipeline_.closure("")) {
      CommitRequest request;
      request.result.key_text = key_text(*task, scan_input, results);
      request.result.run = {0.4, 200 << 20, "host", "0.1.0", "no result yet"};
      for (const std::string& output : task->outputs) {
        request.outputs[output] = output.ends_with(".json")
                                      ? fmt::format("{{\"of\": \"{} {}\"}}\n", output, i)
                                      : fmt::format("{} {}\n", output, i);
      }
      record.set_current(task->name, request.result.key_text.key());
      if (task == pipeline_.closure("").back()) request.subject = record;
      const Result result = store_.commit(std::move(request)).result;
      record.set_current(task->name, make_note(result));
      results[task->name] = result;
    }
    store_.save_subject(record);
  }

  KeyText key_text(const Task& task, const ScanInput& scan_input,
                   const std::map<std::string, Result>& results) const {
    InputDigests inputs;
    for (const TaskInput& input : task.inputs) {
      switch (input.kind) {
        case TaskInput::Kind::kScan:
          inputs.digests[input.name] = scan_input.digest;
          inputs.scan_extension = scan_input.extension;
          break;
        case TaskInput::Kind::kTemplateMesh:
          inputs.digests[input.name] = head_.mesh_digest;
          break;
        case TaskInput::Kind::kTemplateAnnotations:
          inputs.digests[input.name] = head_.annotations_digest;
          break;
        case TaskInput::Kind::kOutput:
          inputs.digests[input.name] = results.at(input.stage).outputs.at(input.output).digest;
      }
    }
    return make_key_text(task, resolve_parameters(task.parameters, task.name, {}), inputs);
  }

  fs::path folder_;
  mutable QuickDisk disk_;
  Pipeline pipeline_;
  TemplateFiles head_;
  Store store_;
};

struct Measured {
  double seconds = 0, processor_seconds = 0;
  std::uint64_t peak_memory_bytes = 0;
  bool is_right = true;
};

/// One run to warm up, then the median of five. `line` must be there `count` times.
Measured measure(const StoreBench& bench, std::vector<std::string> arguments, const std::string& word) {
  std::vector<double> seconds, processor;
  Measured measured;
  const fs::path head = fs::path(PHIZ_SOURCE_FOLDER) / "samples/generic_head";
  if (arguments.front() == "fit") arguments.insert(arguments.end(), {"--template", head.string()});
  for (int run = 0; run < 6; ++run) {
    const auto ended = run_phiz(bench.scratch / "many" / "store", arguments);
    int found = 0;
    for (std::size_t at = ended.out.find(word); at != std::string::npos; at = ended.out.find(word, at + 1))
      ++found;
    measured.is_right = measured.is_right && ended.exit_code == 0 && found == kSubjects;
    if (run == 0) continue;
    seconds.push_back(ended.seconds);
    processor.push_back(ended.processor_seconds);
    measured.peak_memory_bytes = std::max(measured.peak_memory_bytes, ended.peak_memory_bytes);
  }
  measured.seconds = median(seconds);
  measured.processor_seconds = median(processor);
  return measured;
}

void report(const StoreBench& bench, const std::string& what, const Measured& measured, double bar_s) {
  if (!measured.is_right)
    return bench.board.add_missing(what, at_most(bar_s), "not every subject was found finished");
  bench.board.add({what, measured.seconds, "s", at_most(bar_s)});
  bench.board.add({what + ", processor time", measured.processor_seconds, "s", {}});
  bench.board.add({what + ", peak memory", static_cast<double>(measured.peak_memory_bytes) / (1 << 20), "MiB",
                   at_most(200)});
}

}  // namespace

void measure_many_subjects(const StoreBench& bench) {
  const fs::path folder = bench.scratch / "many";
  fs::create_directories(folder);
  FinishedStore(folder).make();
  bench.board.note("10,000 finished subjects of five stages, eleven outputs of a few bytes each");
  const std::string list = (folder / "subjects.csv").string();
  report(bench, "fit --list, nothing to do", measure(bench, {"fit", "--list", list}, ": nothing to do"), 2);
  report(bench, "status", measure(bench, {"status"}, " done "), 0.5);
  const Measured json = measure(bench, {"status", "--json"}, "\"type\":\"status\"");
  bench.board.add({"status --json", json.seconds, "s", {}});
  const Measured rehashed = measure(bench, {"fit", "--read-scans", "--list", list}, ": nothing to do");
  bench.board.add({"fit --list --read-scans", rehashed.seconds, "s", {}});
  fs::remove(folder / "store/results" / fs::directory_iterator(folder / "store/results")->path().filename());
  const auto status = run_phiz(folder / "store", {"status"});
  const bool is_seen = status.out.find(" missing ") != std::string::npos;
  bench.board.add({"a result removed behind its back: status says so", is_seen ? 1.0 : 0.0, "", at_least(1)});
  fs::remove_all(folder);
}

}  // namespace phiz::bench
