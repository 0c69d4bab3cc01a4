#pragma once

#include <vector>

#include "orchestrator/command.h"
#include "orchestrator/task.h"

namespace phiz {

/// main() of the engine: phiz with every stage and command.
int run_engine(int argc, char** argv, std::vector<Task> tasks, std::vector<Command> commands);

/// main() of the front: answers what needs no stage (finished work, status, why ...) within milliseconds, and
/// replaces itself by the engine, `phiz-engine` beside it or in ../libexec/phiz, for everything else. Loading
/// the libraries of the stages alone takes longer than such an answer may.
int run_front(int argc, char** argv, std::vector<Task> tables, std::vector<Command> light_commands);

}  // namespace phiz
