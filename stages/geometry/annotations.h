#pragma once

#include <vector>

#include "formats/control_mesh.h"

namespace phiz {

/// Throws InvalidInput that names the first thing a fit needs and the generic head's annotations lack: the
/// boxes ear_left, ear_right, nose and mouth (each with vertices in it) and the clipping planes neck and
/// back.
void require_annotations(const ControlMesh& generic_head);

/// Per control vertex, 1 where a scan tells nothing to be relied on: the constrained vertices with their
/// neighbours, which are the hems of lids and lips that turn inwards, and the region `eyes`, which shines.
/// Its shape comes from the generic head. O(vertices + triangles).
std::vector<char> find_hidden(const ControlMesh& generic_head);

}  // namespace phiz
