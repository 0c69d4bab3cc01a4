#pragma once

#include <functional>
#include <string>

#include "tests/bench/areas.h"

namespace phiz::bench {

/// main() of an area: reads --json and --long, finds the data, describes the run, measures. 0 where nothing
/// fell short or there is no data, 1 where something did or broke, 2 for a bad command line.
int run_area(const std::string& area, int argc, char** argv,
             const std::function<void(const BenchWorld&)>& measure);

}  // namespace phiz::bench
