#include "orchestrator/run_context.h"

#include <algorithm>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

constexpr std::chrono::milliseconds kProgressPeriod{50};

}  // namespace

RunContext::RunContext(World world) : world_(std::move(world)), checkpoint_(world_.store, world_.key) {}

const TaskInput& RunContext::find_input(const std::string& name) const {
  for (const TaskInput& input : world_.task.inputs) {
    if (input.name == name) return input;
  }
  throw ContractViolation(world_.task.name + " has no input " + name);
}

std::string RunContext::read_input(const std::string& name) {
  switch (find_input(name).kind) {
    case TaskInput::Kind::kScan:
      return read_scan(world_.store.files(), world_.scan);
    case TaskInput::Kind::kTemplateMesh:
      return world_.head.mesh;
    case TaskInput::Kind::kTemplateAnnotations:
      return world_.head.annotations;
    case TaskInput::Kind::kOutput:
      break;
  }
  return world_.store.read_object(world_.inputs.at(name));
}

std::string RunContext::describe_input(const std::string& name) const {
  const TaskInput& input = find_input(name);
  switch (input.kind) {
    case TaskInput::Kind::kScan:
      return world_.scan.path.string();
    case TaskInput::Kind::kTemplateMesh:
      return world_.head.mesh_path.string();
    case TaskInput::Kind::kTemplateAnnotations:
      return world_.head.annotations_path.string();
    case TaskInput::Kind::kOutput:
      break;
  }
  return input.stage + "/" + input.output;
}

const ParameterValue& RunContext::parameter(const std::string& name) const {
  const auto found = world_.parameters.find(name);
  if (found == world_.parameters.end()) {
    throw ContractViolation(world_.task.name + " has no parameter " + name);
  }
  return found->second;
}

void RunContext::write_output(const std::string& name, std::string bytes) {
  const std::vector<std::string>& names = world_.task.outputs;
  CONTRACT(std::count(names.begin(), names.end(), name) == 1);
  CONTRACT(outputs_.emplace(name, std::move(bytes)).second);
}

void RunContext::progress(double fraction, std::optional<double> residual) {
  world_.stop.throw_if_requested();
  const Clock::rep now = Clock::now().time_since_epoch().count();
  Clock::rep last = last_progress_.load();
  const bool is_due = now - last >= Clock::duration(kProgressPeriod).count() || fraction >= 1;
  if (is_due && last_progress_.compare_exchange_strong(last, now)) {
    world_.reporter.step_progress(world_.place, fraction, residual);
  }
}

bool RunContext::checkpoint_due(double seconds) const {
  return Clock::now() - last_checkpoint_ >= std::chrono::duration<double>(seconds);
}

void RunContext::save_checkpoint(std::span<const std::byte> bytes) {
  checkpoint_.save(bytes);
  last_checkpoint_ = Clock::now();
}

std::map<std::string, std::string> RunContext::take_outputs() {
  for (const std::string& name : world_.task.outputs) CONTRACT(outputs_.contains(name));
  return std::move(outputs_);
}

}  // namespace phiz
