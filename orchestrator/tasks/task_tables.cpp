#include "orchestrator/tasks/stages.h"
#include "orchestrator/tasks/tasks.h"

namespace phiz {

std::vector<Task> list_task_tables() {
  return {describe_ingest(),    describe_align(),  describe_fit_local(), describe_fit_global(),
          describe_subdivide(), describe_unwrap(), describe_views()};
}

}  // namespace phiz
