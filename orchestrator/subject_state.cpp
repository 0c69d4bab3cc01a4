#include "orchestrator/subject_state.h"

#include <map>

namespace phiz {
namespace {

const Digest* find_digest(const std::map<std::string, Digest>& digests, const std::string& name) {
  const auto found = digests.find(name);
  return found == digests.end() ? nullptr : &found->second;
}

/// A stage's state, and the note it was judged by.
struct Judged {
  const StageState* state;
  ResultNote note;
};

bool is_made_from(const ResultNote& note, const Task& task, const SubjectRecord& record,
                  const std::map<std::string, Judged>& earlier) {
  for (const TaskInput& input : task.inputs) {
    const bool is_scan = input.kind == TaskInput::Kind::kScan;
    if (!is_scan && input.kind != TaskInput::Kind::kOutput) continue;
    const Digest* used = find_digest(note.inputs, input.name);
    if (used == nullptr) return false;
    if (is_scan) {
      if (*used != record.scan_digest) return false;
      continue;
    }
    const Judged& judged = earlier.at(input.stage);
    if (judged.state->status != StageState::Status::kDone) return false;
    const auto output = judged.note.outputs.find(input.output);
    if (output == judged.note.outputs.end() || output->second.digest != *used) return false;
  }
  return true;
}

/// How a stage's result is looked for.
struct Look {
  const Store& store;
  const SubjectRecord& record;
  bool trusts_notes = false;
  const StoreNames* names = nullptr;

  /// Fills in the result as far as wanted. The note to judge it by; nothing if it or an output is gone.
  std::optional<ResultNote> find_whole(StageState& state) const {
    const ResultNote* noted = trusts_notes ? record.find_note(state.stage) : nullptr;
    if (noted != nullptr) {
      state.seconds = noted->seconds;
      if (names != nullptr && names->has(*noted)) return *noted;
      if (store.has(*noted, Store::Care::kLook)) return *noted;
      return std::nullopt;
    }
    state.result = store.find_result(*state.key);
    if (!state.result) return std::nullopt;
    state.seconds = state.result->run.seconds;
    if (!store.list_missing_outputs(*state.result).empty()) return std::nullopt;
    return make_note(*state.result);
  }
};

std::vector<StageState> compute(const Look& look, const Pipeline& pipeline) {
  std::vector<StageState> states;
  states.reserve(pipeline.tasks().size());
  std::map<std::string, Judged> earlier;
  for (const Task& task : pipeline.tasks()) {
    const Digest* key = find_digest(look.record.results, task.name);
    if (key == nullptr && !task.option.empty()) continue;
    StageState& state = states.emplace_back();
    state.stage = task.name;
    Judged& judged = earlier[task.name];
    judged.state = &state;
    if (key == nullptr) continue;
    state.key = *key;
    auto note = look.find_whole(state);
    if (!note) {
      state.status = StageState::Status::kMissing;
      continue;
    }
    const bool is_current = is_made_from(*note, task, look.record, earlier);
    state.status = is_current ? StageState::Status::kDone : StageState::Status::kStale;
    judged.note = std::move(*note);
  }
  return states;
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
  return compute({store, record}, pipeline);
}

std::vector<StageState> look_at_subject_state(const Store& store, const Pipeline& pipeline,
                                              const SubjectRecord& record, const StoreNames* names) {
  return compute({store, record, true, names}, pipeline);
}

}  // namespace phiz
