#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "orchestrator/child_program.h"
#include "orchestrator/pipeline.h"
#include "orchestrator/stop.h"
#include "store/file_system.h"
#include "store/process.h"

namespace phiz {

struct Command;

/// Everything a run of phiz touches outside its own memory. main() fills it with the real things, tests with
/// theirs.
struct Environment {
  std::ostream& out;
  std::ostream& err;
  FileSystem& files;
  Processes& processes;
  const Pipeline& pipeline;
  const std::vector<Command>& commands;
  const StopFlag& stop;
  std::function<std::optional<std::string>(const std::string& name)> find_variable;  ///< of the environment
  std::filesystem::path program_folder;  ///< where the program lies; empty if unknown
  bool err_is_terminal = false;
  bool is_front = false;  ///< only tables are linked: what needs more throws EngineNeeded
  std::function<ChildAnswer(const std::vector<std::string>& argv)> run_child =
      run_child_program;  ///< other programs
};

}  // namespace phiz
