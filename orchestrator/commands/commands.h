#pragma once

#include <vector>

#include "orchestrator/command.h"

namespace phiz {

// One file each in this folder. Those of the first group need no stage; those of the second do.
Command make_fit_command();
Command make_status_command();
Command make_log_command();
Command make_why_command();
Command make_explain_command();
Command make_store_command();

Command make_export_command();
Command make_evaluate_command();
Command make_report_command();
Command make_fields_command();
Command make_retarget_command();
Command make_adapt_command();
Command make_track_command();
Command make_animate_command();
Command make_synth_command();
Command make_template_command();

Command make_verify_command();                      // store_verify.cpp: `store verify`
std::vector<Command> list_store_upkeep_commands();  // store_upkeep.cpp: children of `store`
std::vector<Command> list_pin_commands();           // store_pins.cpp: likewise

/// Commands that need no stage: they answer without loading the libraries of the stages.
std::vector<Command> list_light_commands();  // light_commands.cpp

/// Every command, in the order of `phiz --help`.
std::vector<Command> list_commands();  // all_commands.cpp

}  // namespace phiz
