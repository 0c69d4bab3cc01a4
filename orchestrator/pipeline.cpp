#include "orchestrator/pipeline.h"

#include <algorithm>
#include <set>

#include "orchestrator/error.h"
#include "stages/geometry/error.h"

namespace phiz {
namespace {

bool is_ready(const Task& task, const std::map<std::string, const Task*>& done) {
  return std::all_of(task.inputs.begin(), task.inputs.end(), [&](const TaskInput& input) {
    return input.kind != TaskInput::Kind::kOutput || done.contains(input.stage);
  });
}

void check_inputs(const Task& task, const std::map<std::string, const Task*>& done) {
  for (const TaskInput& input : task.inputs) {
    if (input.kind != TaskInput::Kind::kOutput) continue;
    const std::vector<std::string>& outputs = done.at(input.stage)->outputs;
    CONTRACT(std::count(outputs.begin(), outputs.end(), input.output) == 1);
  }
}

std::string describe_side(const std::optional<std::string>& value) {
  return value ? *value : "(none)";
}

}  // namespace

TaskInput scan_input() {
  return {"scan", TaskInput::Kind::kScan, {}, {}};
}
TaskInput template_mesh_input() {
  return {"template.obj", TaskInput::Kind::kTemplateMesh, {}, {}};
}
TaskInput template_annotations_input() {
  return {"template.json", TaskInput::Kind::kTemplateAnnotations, {}, {}};
}
TaskInput output_of(const std::string& stage, const std::string& output) {
  return {output, TaskInput::Kind::kOutput, stage, output};
}

Pipeline::Pipeline(std::vector<Task> tasks) {
  std::map<std::string, const Task*> done;
  std::vector<bool> placed(tasks.size(), false);
  tasks_.reserve(tasks.size());
  while (tasks_.size() < tasks.size()) {
    std::size_t next = 0;
    while (next < tasks.size() && (placed[next] || !is_ready(tasks[next], done))) ++next;
    CONTRACT(next < tasks.size());
    check_inputs(tasks[next], done);
    placed[next] = true;
    tasks_.push_back(std::move(tasks[next]));
    CONTRACT(done.emplace(tasks_.back().name, &tasks_.back()).second);
  }
}

const Task* Pipeline::find(const std::string& name) const {
  const auto found =
      std::find_if(tasks_.begin(), tasks_.end(), [&](const Task& task) { return task.name == name; });
  return found == tasks_.end() ? nullptr : &*found;
}

const Task& Pipeline::get(const std::string& name) const {
  if (const Task* task = find(name)) return *task;
  std::string names;
  for (const Task& task : tasks_) names += (names.empty() ? "" : ", ") + task.name;
  throw UsageError("there is no stage '" + name + "'", "the stages are: " + names);
}

std::vector<const Task*> Pipeline::closure(const std::string& last,
                                           const std::vector<std::string>& extras) const {
  std::set<std::string> needed(extras.begin(), extras.end());
  if (!last.empty()) needed.insert(get(last).name);
  std::vector<const Task*> order;
  for (auto task = tasks_.rbegin(); task != tasks_.rend(); ++task) {
    const bool always_runs = last.empty() && task->option.empty();
    if (!always_runs && !needed.contains(task->name)) continue;
    order.push_back(&*task);
    for (const TaskInput& input : task->inputs) needed.insert(input.stage);
  }
  std::reverse(order.begin(), order.end());
  return order;
}

void Pipeline::add_setting(const std::string& assignment, Settings& settings) const {
  const std::size_t equals = assignment.find('=');
  const std::size_t dot = assignment.find('.');
  if (equals == std::string::npos || dot == std::string::npos || dot > equals) {
    throw UsageError("--set " + assignment + ": not of the form stage.param=value",
                     "for example --set ingest.units=mm");
  }
  const Task& task = get(assignment.substr(0, dot));
  const std::string name = assignment.substr(dot + 1, equals - dot - 1);
  for (const Parameter& parameter : task.parameters) {
    if (parameter.name != name) continue;
    settings[task.name][name] =
        parse_value(parameter, assignment.substr(equals + 1), task.name + "." + parameter.name);
    return;
  }
  throw UsageError(task.name + " has no parameter '" + name + "'", "see phiz explain " + task.name);
}

KeyText make_key_text(const Task& task, const ParameterValues& parameters, const InputDigests& inputs) {
  KeyText text;
  text.add("stage", "name", task.name);
  text.add("version", "number", std::to_string(task.version));
  for (const auto& [name, value] : parameters) text.add("parameter", name, format_value(value));
  for (const auto& [name, digest] : inputs.digests) text.add("input", name, digest.hex());
  if (!inputs.scan_extension.empty()) text.add("input", "scan.extension", inputs.scan_extension);
  return text;
}

std::string describe_differences(const std::vector<KeyDifference>& differences) {
  std::string text;
  for (const KeyDifference& difference : differences) {
    if (!text.empty()) text += "; ";
    const bool is_digest = difference.tag == "input" && difference.before && difference.after &&
                           parse_digest(*difference.before) && parse_digest(*difference.after);
    if (is_digest) {
      text += "input " + difference.name + " changed";
    } else {
      text += difference.tag + " " + difference.name + ": " + describe_side(difference.before) + " -> " +
              describe_side(difference.after);
    }
  }
  return text;
}

}  // namespace phiz
