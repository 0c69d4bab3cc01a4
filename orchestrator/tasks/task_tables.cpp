#include "orchestrator/tasks/tasks.h"

namespace phiz {

std::vector<Task> list_task_tables() { return {}; }

}  // namespace phiz
