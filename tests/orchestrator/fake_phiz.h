#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "orchestrator/command.h"
#include "orchestrator/environment.h"
#include "orchestrator/pipeline.h"
#include "store/store.h"
#include "tests/store/memory_file_system.h"

namespace phiz::test {

/// What the fake stages were asked to do, and what they did.
struct FakeStages {
  std::map<std::string, int> runs;  ///< stage -> how often it was computed
  std::string fail_at;              ///< this stage throws NumericalFailure
  int stop_at_step = -1;            ///< `join` asks for a stop when it reaches this step
  int first_step = -1;              ///< where `join` began: after a checkpoint not at 0
  int step_milliseconds = 0;        ///< how long a step of `join` takes
  std::function<void(const std::string&)> on_event = [](const std::string&) {
  };  ///< "begin join", "saved 3" ...
  StopFlag stop;
  std::mutex mutex;
};

/// Three small stages that work on text: `read` splits the scan into words, `join` puts them together step by
/// step with checkpoints, `finish` makes "head.glb" and a summary; `look` runs only with --look. A scan that
/// holds "bad" is refused by `read`, one that holds "blob" is rejected by `finish`.
std::vector<Task> make_fake_tasks(FakeStages& stages);

/// Each run is a process of its own, and the only one alive.
class FakeProcesses final : public Processes {
 public:
  ProcessIdentity self() override { return {"a machine", current_, 1}; }
  bool is_alive(const ProcessIdentity& identity) override { return identity.pid == current_; }
  double now_seconds() override { return 0; }
  void start_next() { ++current_; }

 private:
  std::int64_t current_ = 1;
};

/// phiz on an in-memory disk with the fake stages, a scan /scans/a.xyz, a template, and a captured terminal.
class FakePhiz {
 public:
  FakePhiz();

  /// Runs the program and returns its exit code. --store and --template are added.
  int run(std::vector<std::string> arguments) { return run_on(disk, std::move(arguments)); }
  int run_on(FileSystem& files, std::vector<std::string> arguments);

  void add_file(const std::string& path, const std::string& text);
  Store open_store() { return Store::open(disk, "/disk/store"); }
  /// Digest of an output of a subject's current result.
  Digest digest_of(const std::string& subject, const std::string& stage, const std::string& output);

  MemoryFileSystem disk;
  FakeStages stages;
  FakeProcesses processes;
  bool is_front = false;
  /// Other programs: there are none.
  std::function<ChildAnswer(const std::vector<std::string>&)> run_child =
      [](const std::vector<std::string>&) {
        return ChildAnswer{127, {}, "no such program"};
      };
  std::map<std::string, std::string> variables;
  std::string out, err;  ///< of the last run
};

}  // namespace phiz::test
