#pragma once

#include <string>
#include <vector>

namespace phiz {

/// What another program said, and how it ended.
struct ChildAnswer {
  int exit_code = 0;  ///< 128 + signal where a signal ended it, 127 where it could not be started
  std::string out, err;
};

/// Runs a program to its end without any input. argv[0] is looked for in PATH. Blocks.
ChildAnswer run_child_program(const std::vector<std::string>& argv);

}  // namespace phiz
