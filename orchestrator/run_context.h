#pragma once

#include <chrono>
#include <map>
#include <string>

#include "orchestrator/inputs.h"
#include "orchestrator/report.h"
#include "orchestrator/stop.h"
#include "orchestrator/task.h"
#include "store/checkpoint.h"
#include "store/store.h"

namespace phiz {

/// The world of one running step: reads from the store, keeps the outputs for the commit.
class RunContext final : public TaskContext {
 public:
  struct World {
    const Store& store;
    const Task& task;
    const ScanInput& scan;
    const TemplateFiles& head;
    const ParameterValues& parameters;
    const std::map<std::string, Digest>& inputs;
    Reporter& reporter;
    const StopFlag& stop;
    Memo& memo;
    StepPlace place;
    Digest key;
  };
  explicit RunContext(World world);

  std::string read_input(const std::string& name) override;
  std::string describe_input(const std::string& name) const override;
  std::string scan_extension() const override { return world_.scan.extension; }
  Digest input_digest(const std::string& name) const override { return world_.inputs.at(name); }
  Digest template_digest() const override { return world_.head.digest; }
  Memo& memo() override { return world_.memo; }
  const ParameterValue& parameter(const std::string& name) const override;
  void write_output(const std::string& name, std::string bytes) override;
  void progress(double fraction, std::optional<double> residual) override;
  void note(const std::string& line) override { world_.reporter.note(world_.place, line); }
  bool stop_requested() const override { return world_.stop.signal() != 0; }
  std::optional<std::string> load_checkpoint() override { return checkpoint_.load(); }
  bool checkpoint_due(double seconds) const override;
  void save_checkpoint(std::span<const std::byte> bytes) override;

  const Checkpoint& checkpoint() const { return checkpoint_; }

  /// What the task wrote. ContractViolation if an output of its table is missing.
  std::map<std::string, std::string> take_outputs();

 private:
  using Clock = std::chrono::steady_clock;
  const TaskInput& find_input(const std::string& name) const;

  World world_;
  Checkpoint checkpoint_;
  std::map<std::string, std::string> outputs_;
  Clock::time_point last_checkpoint_ = Clock::now();
  std::atomic<Clock::rep> last_progress_ = 0;
};

}  // namespace phiz
