#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "orchestrator/command.h"
#include "orchestrator/environment.h"

namespace phiz {

/// Options every command has.
struct GlobalOptions {
  std::optional<std::string> store;
  std::optional<int> threads;
  std::optional<std::string> max_memory;  ///< as written: "4G"
  bool is_json = false, is_quiet = false, is_verbose = false, is_dry_run = false;
};

/// What the command line asks for.
struct ParsedCommandLine {
  GlobalOptions globals;
  Command::Action action;           ///< empty if `text` is all there is to do
  std::optional<std::string> text;  ///< --help, --version: to be printed
};

/// Reads argv (without the program's name) and --config FILE.toml. Throws UsageError.
ParsedCommandLine parse_command_line(std::span<const std::string> arguments, const Environment& environment);

}  // namespace phiz
