#pragma once

#include <map>
#include <string>

#include "orchestrator/task.h"

namespace phiz {

/// For stages that make several outputs one after the other: those that an interrupted run has finished are
/// not made again. They lie in the stage's checkpoint, which is saved when more than a second of work would
/// be lost.
class KeptOutputs {
 public:
  explicit KeptOutputs(TaskContext& context);

  /// True, and written, if an interrupted run has made it.
  bool write_kept(const std::string& output);
  void write(const std::string& output, std::string bytes);

 private:
  TaskContext& context_;
  std::map<std::string, std::string> outputs_;
};

}  // namespace phiz
