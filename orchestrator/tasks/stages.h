#pragma once

#include "orchestrator/task.h"

namespace phiz {

// A stage as a task is two functions in two files: its table, which links nothing of the stage, and its run.
Task describe_ingest();      // ingest_table.cpp
Task describe_align();       // align_table.cpp
Task describe_fit_local();   // fit_table.cpp
Task describe_fit_global();  // fit_table.cpp
Task describe_subdivide();   // subdivide_table.cpp
Task describe_unwrap();      // unwrap_table.cpp
Task describe_views();       // views_table.cpp

void run_ingest(TaskContext& context);      // ingest.cpp
void run_align(TaskContext& context);       // align.cpp
void run_fit_local(TaskContext& context);   // fit_local.cpp
void run_fit_global(TaskContext& context);  // fit_global.cpp
void run_subdivide(TaskContext& context);   // subdivide.cpp
void run_unwrap(TaskContext& context);      // unwrap.cpp
void run_views(TaskContext& context);       // views.cpp

}  // namespace phiz
