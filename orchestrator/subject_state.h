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
/// have none. kFull reads every result's file. kQuick only looks whether what the record's notes say is
/// there, by names and lengths; without a note it reads the file.
enum class StateDetail { kFull, kQuick };
std::vector<StageState> compute_subject_state(const Store& store, const Pipeline& pipeline,
                                              const SubjectRecord& record,
                                              StateDetail detail = StateDetail::kFull);

}  // namespace phiz
