#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "stages/subdivide/subdivide.h"

namespace phiz {

/// The vertices that one level may displace, as a graph of their own: at level 0 the control mesh, above it
/// the new vertices and the edges between them (old ones do not move and take no part).
struct DisplacementGraph {
  std::vector<int> offsets;      ///< vertex count + 1
  std::vector<int> neighbours;   ///< counted from the level's first displaced vertex
  std::vector<double> lengths;   ///< of the edges, mm
  std::vector<double> spacings;  ///< mean length of all edges at a vertex, to old vertices too
  std::vector<double> to_old;    ///< length of the shorter edge to an old vertex; infinity at level 0
  int vertex_count() const { return static_cast<int>(offsets.size()) - 1; }
};

DisplacementGraph build_displacement_graph(const SubdivisionHierarchy& hierarchy, int level,
                                           const std::vector<Eigen::Vector3d>& positions);

/// What is known of the scalars of one level while they are being measured and completed.
struct DisplacementField {
  enum State : std::uint8_t {
    kUnknown,  ///< nothing measured there: stays at 0 unless bridged
    kHeld,     ///< not to be measured: stays at 0
    kMeasured,
    kBridged,
  };
  std::vector<double> values;
  std::vector<State> states;
};

/// Takes a measurement back where it differs by more than max_slope times the distance from every one of
/// three or more measured neighbours, while no neighbour has as much against it: one bad sample among good
/// ones.
void reject_spikes(const DisplacementGraph& graph, double max_slope, DisplacementField& field);

/// Relaxes measured values until neighbours differ by at most max_slope times their distance, and a value
/// from old vertices beside it by the same, from held ones by less than a third of it. Of two that are too far apart the one with more such
/// neighbours moves more, so that a spike gives way and its surroundings hardly do. Fixed rounds in fixed
/// order.
void cap_slopes(const DisplacementGraph& graph, double max_slope, DisplacementField& field);

/// Gives unknown vertices within `rings` edges of a measured one the harmonic extension of what surrounds
/// them: the measured values on one side, 0 beyond the rings and on held vertices. They become kBridged.
void bridge_gaps(const DisplacementGraph& graph, int rings, DisplacementField& field);

/// Halves the values at triangles that displacement would turn by more than acos(least_turn_dot), again and
/// again, at last to 0: where they are in conflict with a fold of the surface, detail gives way. What was
/// measured there becomes kBridged. `positions` are the level's undisplaced ones, `normals` those of its last
/// vertices, which the field displaces.
void limit_turns(std::span<const Eigen::Vector3i> triangles, std::span<const Eigen::Vector3d> positions,
                 std::span<const Eigen::Vector3d> normals, double least_turn_dot, DisplacementField& field);

}  // namespace phiz
