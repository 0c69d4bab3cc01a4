#include "orchestrator/subject_state.h"

#include <map>

namespace phiz {
namespace {

/// The value of the key text's entry `input <name>`.
std::string find_input(const Result& result, const std::string& name) {
  for (const KeyText::Entry& entry : result.key_text.entries()) {
    if (entry.tag == "input" && entry.name == name) return entry.value;
  }
  return {};
}

bool is_made_from(const Result& result, const Task& task, const SubjectRecord& record,
                  const std::map<std::string, const StageState*>& earlier) {
  for (const TaskInput& input : task.inputs) {
    if (input.kind == TaskInput::Kind::kScan && find_input(result, input.name) != record.scan_digest.hex())
      return false;
    if (input.kind != TaskInput::Kind::kOutput) continue;
    const StageState& state = *earlier.at(input.stage);
    if (state.status != StageState::Status::kDone) return false;
    const auto output = state.result->outputs.find(input.output);
    if (output == state.result->outputs.end()) return false;
    if (find_input(result, input.name) != output->second.digest.hex()) return false;
  }
  return true;
}

}  // namespace

const char* name_of(StageState::Status status) {
  switch (status) {
    case StageState::Status::kNone:
      return "none";
    case StageState::Status::kDone:
      return "done";
    case StageState::Status::kStale:
      return "stale";
    case StageState::Status::kMissing:
      return "missing";
  }
  return "";
}

std::vector<StageState> compute_subject_state(const Store& store, const Pipeline& pipeline,
                                              const SubjectRecord& record) {
  std::vector<StageState> states;
  states.reserve(pipeline.tasks().size());
  std::map<std::string, const StageState*> earlier;
  for (const Task& task : pipeline.tasks()) {
    const auto key = record.results.find(task.name);
    if (key == record.results.end() && !task.option.empty()) continue;
    StageState& state = states.emplace_back();
    state.stage = task.name;
    earlier[task.name] = &state;
    if (key == record.results.end()) continue;
    state.result = store.find_result(key->second);
    if (!state.result || !store.list_missing_outputs(*state.result).empty()) {
      state.status = StageState::Status::kMissing;
    } else {
      state.status = is_made_from(*state.result, task, record, earlier) ? StageState::Status::kDone
                                                                        : StageState::Status::kStale;
    }
  }
  return states;
}

}  // namespace phiz
