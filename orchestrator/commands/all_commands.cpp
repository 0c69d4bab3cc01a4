#include "orchestrator/commands/commands.h"

namespace phiz {

std::vector<Command> list_commands() {
  std::vector<Command> commands = list_light_commands();
  commands.push_back(make_export_command());
  commands.push_back(make_report_command());
  commands.push_back(make_evaluate_command());
  commands.push_back(make_fields_command());
  commands.push_back(make_retarget_command());
  commands.push_back(make_adapt_command());
  commands.push_back(make_track_command());
  commands.push_back(make_animate_command());
  commands.push_back(make_synth_command());
  commands.push_back(make_template_command());
  return commands;
}

}  // namespace phiz
