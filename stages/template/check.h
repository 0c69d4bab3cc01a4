#pragma once

#include <string>
#include <vector>

#include "formats/control_mesh.h"

namespace phiz {

/// One promise of a generic head.
struct HeadCheck {
  std::string what, value, bar;
  bool ok = false;
};

/// Every promise that phiz makes of a generic head, measured: topology, size, (u,v), valences, symmetry,
/// angles, edge loops, annotations, the limit surface at level 4, vertex order. A later check is left out
/// where an earlier one that it builds on fails. Deterministic. Some seconds.
std::vector<HeadCheck> check_generic_head(const ControlMesh& head);

}  // namespace phiz
