#include "orchestrator/commands/commands.h"
#include "orchestrator/program.h"
#include "orchestrator/tasks/tasks.h"

int main(int argc, char** argv) {
  return phiz::run_engine(argc, argv, phiz::list_tasks(), phiz::list_commands());
}
