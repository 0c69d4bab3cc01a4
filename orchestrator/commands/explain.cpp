#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "orchestrator/commands/commands.h"
#include "orchestrator/error_table.h"
#include "orchestrator/option_set.h"
#include "orchestrator/session.h"

namespace phiz {
namespace {

using nlohmann::ordered_json;

std::string describe_origin(const TaskInput& input) {
  switch (input.kind) {
    case TaskInput::Kind::kScan:
      return "the scan file";
    case TaskInput::Kind::kTemplateMesh:
      return "the generic head's mesh";
    case TaskInput::Kind::kTemplateAnnotations:
      return "the generic head's annotations";
    case TaskInput::Kind::kOutput:
      break;
  }
  return "of " + input.stage;
}

void print_text(const Session& session, const Task& task) {
  session.print(fmt::format("{} (version {}): {}", task.name, task.version, task.doc));
  if (!task.source.empty()) session.print("source: " + task.source);
  for (const TaskInput& input : task.inputs)
    session.print("in   " + input.name + ", " + describe_origin(input));
  for (const std::string& output : task.outputs) session.print("out  " + output);
  for (const Parameter& parameter : task.parameters) {
    std::string line =
        fmt::format("  {}.{} = {}", task.name, parameter.name, format_value(parameter.default_value));
    if (!parameter.unit.empty()) line += " " + parameter.unit;
    line += "  (" + describe_type(parameter) + ")";
    if (!parameter.option.empty()) line += "  " + parameter.option;
    session.print(line);
    session.print("      " + parameter.doc + (parameter.source.empty() ? "" : " [" + parameter.source + "]"));
  }
}

void print_object(const Session& session, const Task& task) {
  ordered_json object = {{"type", "stage"},         {"stage", task.name},
                         {"version", task.version}, {"doc", task.doc},
                         {"source", task.source},   {"inputs", ordered_json::array()},
                         {"outputs", task.outputs}, {"parameters", ordered_json::array()}};
  for (const TaskInput& input : task.inputs) {
    object["inputs"].push_back({{"name", input.name}, {"from", describe_origin(input)}});
  }
  for (const Parameter& parameter : task.parameters) {
    object["parameters"].push_back({{"name", parameter.name},
                                    {"default", format_value(parameter.default_value)},
                                    {"type", describe_type(parameter)},
                                    {"unit", parameter.unit},
                                    {"doc", parameter.doc},
                                    {"source", parameter.source},
                                    {"option", parameter.option}});
  }
  session.print_json(object);
}

int run_explain(const std::vector<std::string>& stages, Session& session) {
  std::vector<const Task*> tasks;
  for (const std::string& stage : stages) tasks.push_back(&session.pipeline().get(stage));
  if (stages.empty()) {
    for (const Task& task : session.pipeline().tasks()) tasks.push_back(&task);
  }
  for (const Task* task : tasks) {
    if (session.globals().is_json) {
      print_object(session, *task);
    } else if (stages.empty()) {
      session.print(fmt::format("{:<12} {}", task->name, task->doc));
    } else {
      print_text(session, *task);
    }
  }
  return kExitDone;
}

}  // namespace

Command make_explain_command() {
  Command command{
      "explain", "a stage's inputs, outputs and parameters with defaults, units and sources", {}, {}};
  command.declare = [](OptionSet& options, const Environment&) -> Command::Action {
    auto stages = std::make_shared<std::vector<std::string>>();
    options.add_positionals("STAGE", *stages, "stages (default: list them)");
    return [stages](Session& session) { return run_explain(*stages, session); };
  };
  return command;
}

}  // namespace phiz
