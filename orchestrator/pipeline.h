#pragma once

#include <map>
#include <string>
#include <vector>

#include "orchestrator/task.h"
#include "store/key.h"

namespace phiz {

/// The stages in an order in which each comes after those it needs.
class Pipeline {
 public:
  /// Keeps the given order among stages that do not depend on each other. A table that cannot work (two
  /// stages of one name, an input that no stage makes, a circle) is a ContractViolation.
  explicit Pipeline(std::vector<Task> tasks);

  const std::vector<Task>& tasks() const { return tasks_; }
  const Task* find(const std::string& name) const;
  const Task& get(const std::string& name) const;  ///< throws UsageError that lists the stages there are

  /// `last` and everything it needs, in order. If `last` is empty, all stages that always run, and `extras`
  /// (stages with an option) with everything they need.
  std::vector<const Task*> closure(const std::string& last,
                                   const std::vector<std::string>& extras = {}) const;

  /// "stage.name=value" -> settings. Throws UsageError.
  void add_setting(const std::string& assignment, Settings& settings) const;

 private:
  std::vector<Task> tasks_;
};

/// Digests of a task's inputs by input name, and the scan's extension where the task reads the scan.
struct InputDigests {
  std::map<std::string, Digest> digests;
  std::string scan_extension;
};

/// The text whose digest names the result of `task` on these inputs.
KeyText make_key_text(const Task& task, const ParameterValues& parameters, const InputDigests& inputs);

/// "parameter voxel_mm: 1 -> 0.5; input scan changed". Empty if nothing differs.
std::string describe_differences(const std::vector<KeyDifference>& differences);

}  // namespace phiz
