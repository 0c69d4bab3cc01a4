#pragma once

#include "formats/control_mesh.h"

namespace phiz {

/// Puts vertices and triangles into an order in which Draco's edgebreaker codec returns them; the annotations
/// follow. The codec starts at the first triangle it is given and returns that one last, so no mesh comes
/// back as it went in. But one in this order comes back exactly if its triangles are handed over last first,
/// and each with its last corner first. The order depends on the connectivity alone and is the same at every
/// speed. Handed over first to last no mesh has such an order: six rounds at speeds 0, 5 and 10 came back
/// changed each time. Whether an order was found; head assets keep any (formats/draco_streams.h). Throws
/// NumericalFailure where Draco cannot encode the mesh.
bool canonicalise_order(ControlMesh& mesh);

/// Whether encoding in this way and decoding leaves every vertex and every triangle in its place.
bool is_canonical_order(const ControlMesh& mesh);

}  // namespace phiz
