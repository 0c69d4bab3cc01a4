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

/// As find_hidden, with the neighbours of hidden vertices in the region `eyelids` too: the edges of the lids,
/// which a fit may move but which are too thin and too near the eye for details to be measured.
std::vector<char> find_unmeasurable(const ControlMesh& generic_head);

}  // namespace phiz
