#pragma once

#include <vector>

#include "stages/geometry/half_edge.h"

namespace phiz {

/// One vertex and its share in a new one.
struct Weighted {
  int vertex_idx = 0;
  double weight = 0;
};

/// How the vertex in the middle of half-edge h's edge follows from the vertices of its level: Modified
/// Butterfly.
///
/// - between two regular vertices (valence 6; on the border three triangles): the eight-point butterfly;
/// where a wing
///   lies beyond the border, the reflection a + b - c of the triangle that is there stands for it
/// - from an extraordinary vertex: the rule of its valence over its one-ring (inside: Zorin, Schroeder,
/// Sweldens 1996;
///   on the border: Zorin's thesis 1997, sine series over the half-disk); both ends extraordinary: the mean
///   of both
/// - on the border: the four-point rule along it, so that the border is a curve of its own
///
/// Each vertex once, in order of first use; zero weights left out; weights are multiples of 2^-49 and sum to
/// exactly 1.
void compute_edge_rule(const HalfEdgeMesh& mesh, int h, std::vector<Weighted>& row);

}  // namespace phiz
