#include "orchestrator/commands/commands.h"
#include "orchestrator/program.h"
#include "orchestrator/tasks/tasks.h"

int main(int argc, char** argv) {
  return phiz::run_front(argc, argv, phiz::list_task_tables(), phiz::list_light_commands());
}
