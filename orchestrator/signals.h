#pragma once

#include "orchestrator/stop.h"

namespace phiz {

/// SIGINT and SIGTERM set the returned flag; work stops at its next safe point. If it has not within a second
/// the process says how to continue and exits: the store is sound at any instant. A second SIGINT exits at
/// once.
StopFlag& install_stop_signals(bool is_json);

}  // namespace phiz
