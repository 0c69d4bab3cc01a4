#pragma once

#include <vector>

#include "orchestrator/command.h"

namespace phiz {

// One file each in this folder.
Command make_fit_command();
Command make_status_command();
Command make_why_command();
Command make_explain_command();
Command make_store_command();

/// Commands that need no stage: they answer without loading the libraries of the stages.
std::vector<Command> list_light_commands();

}  // namespace phiz
