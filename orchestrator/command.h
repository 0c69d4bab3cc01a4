#pragma once

#include <functional>
#include <string>
#include <vector>

namespace phiz {

struct Environment;
class OptionSet;
class Session;

/// One command of phiz. A file in commands/ makes one; commands/registry.cpp lists them.
struct Command {
  using Action = std::function<int(Session&)>;  ///< returns the exit code; throws what the error table knows

  std::string name;     ///< "fit"
  std::string summary;  ///< one line of `phiz --help`
  /// Declares the options and returns what runs once they are read. Values live in what the action captures.
  std::function<Action(OptionSet& options, const Environment& environment)> declare;
  std::vector<Command> children;  ///< "store ls": a command with children has no action of its own
};

}  // namespace phiz
