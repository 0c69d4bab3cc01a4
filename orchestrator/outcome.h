#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "orchestrator/error_table.h"
#include "store/digest.h"
#include "store/result.h"

namespace phiz {

/// Which step of which subject.
struct StepPlace {
  std::string subject, stage;
};

/// How one step of one subject ended.
struct StepOutcome {
  enum class Status {
    kKept,          ///< the result was there
    kComputed,      ///< it was computed now
    kWouldCompute,  ///< --dry-run: it would be
  };
  std::string stage;
  Status status = Status::kKept;
  std::string reason;            ///< why it was or would be computed
  std::optional<Result> result;  ///< absent if it would be computed
  double seconds = 0;
};

/// How one subject ended.
struct SubjectOutcome {
  std::string subject;
  std::vector<StepOutcome> steps;                ///< up to the one that failed
  std::map<std::string, std::string> summaries;  ///< stage -> its summary, a JSON object
  std::optional<Failure> failure;
  std::string failed_stage;  ///< empty if it failed outside any stage
  double seconds = 0;
};

}  // namespace phiz
