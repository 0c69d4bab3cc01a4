#include "orchestrator/commands/commands.h"

namespace phiz {

std::vector<Command> list_light_commands() {
  return {make_fit_command(), make_status_command(),  make_log_command(),
          make_why_command(), make_explain_command(), make_store_command()};
}

}  // namespace phiz
