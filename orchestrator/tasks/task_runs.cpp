#include <map>

#include "orchestrator/tasks/stages.h"
#include "orchestrator/tasks/tasks.h"
#include "stages/geometry/error.h"

namespace phiz {

std::vector<Task> list_tasks() {
  const std::map<std::string, void (*)(TaskContext&)> runs = {
      {"ingest", run_ingest},       {"align", run_align},
      {"fit_local", run_fit_local}, {"fit_global", run_fit_global},
      {"subdivide", run_subdivide}, {"unwrap", run_unwrap},
      {"views", run_views}};
  std::vector<Task> tasks = list_task_tables();
  CONTRACT(tasks.size() == runs.size());
  for (Task& task : tasks) task.run = runs.at(task.name);
  return tasks;
}

}  // namespace phiz
