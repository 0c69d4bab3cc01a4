#pragma once

#include <string>
#include <vector>

#include "tests/lint/source_tree.h"

namespace phiz::lint {

/// Breaches of the table of layers, as "path:line: what". The table:
///   formats and store include nobody else of ours; stages include formats, stages/geometry and, never in a
///   circle, the one public header (stages/X/X.h) of another stage; orchestrator includes all three; nobody
///   includes tests. OpenVDB, OpenEXR, Draco, CGAL, GL and nanoflann stay in .cpp files. Ours are included by
///   their path from the root.
std::vector<std::string> find_layer_violations(const std::vector<SourceFile>& files);

}  // namespace phiz::lint
