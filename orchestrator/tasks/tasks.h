#pragma once

#include <vector>

#include "orchestrator/task.h"

namespace phiz {

/// The stages of phiz without their code: names, versions, parameters, inputs, outputs. Links no stage.
std::vector<Task> list_task_tables();

/// The stages with their code. Links all of them.
std::vector<Task> list_tasks();

}  // namespace phiz
