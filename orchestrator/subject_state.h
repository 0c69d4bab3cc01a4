#pragma once

#include <optional>
#include <string>
#include <vector>

#include "orchestrator/pipeline.h"
#include "store/store.h"

namespace phiz {

/// Where one subject stands at one stage.
struct StageState {
  enum class Status {
    kNone,     ///< never computed
    kDone,     ///< the result is there, and made from the current results of earlier stages
    kStale,    ///< there, but earlier results have changed since
    kMissing,  ///< it was computed, but its result or an output is gone
  };
  std::string stage;
  Status status = Status::kNone;
  std::optional<Digest> key;     ///< of its current result
  double seconds = 0;            ///< it took to compute
  std::optional<Result> result;  ///< where there is one, and it was read
};

const char* name_of(StageState::Status status);

/// One entry a stage, in the pipeline's order; stages that run only where asked for and were never computed
/// have none. Reads every result's file, looks at the outputs' lengths, hashes nothing.
std::vector<StageState> compute_subject_state(const Store& store, const Pipeline& pipeline,
                                              const SubjectRecord& record);

/// Likewise, by the record's notes: whether what they say is there, by name (as `names` has it) or else by
/// name and length. Reads no result's file where there is a note.
std::vector<StageState> look_at_subject_state(const Store& store, const Pipeline& pipeline,
                                              const SubjectRecord& record, const StoreNames* names = nullptr);

}  // namespace phiz
