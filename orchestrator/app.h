#pragma once

#include <span>
#include <string>

#include "orchestrator/environment.h"

namespace phiz {

/// A whole run of phiz: reads the command line, carries it out, reports. Returns the exit code and never
/// throws, except EngineNeeded when environment.is_front.
int run_phiz(std::span<const std::string> arguments, const Environment& environment);

}  // namespace phiz
