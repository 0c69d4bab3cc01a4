#pragma once

#include "formats/control_mesh.h"

namespace phiz {

/// Throws InvalidInput that names the first thing a fit needs and the generic head's annotations lack: the
/// boxes ear_left, ear_right, nose and mouth (each with vertices in it) and the clipping planes neck and
/// back.
void require_annotations(const ControlMesh& generic_head);

}  // namespace phiz
