#pragma once

#include <string>

#include "formats/control_mesh.h"
#include "orchestrator/commands/report_page.h"

namespace phiz {

/// Fills in distances of the clean cloud to the finished surface, by region, and pictures of the head and of
/// the distances on it. Throws FormatError.
void measure_residuals(const std::string& asset_bytes, const std::string& cloud_bytes,
                       const ControlMesh& generic, SubjectReport& report);

}  // namespace phiz
