#include "stages/subdivide/displacement_field.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "stages/geometry/half_edge.h"
#include "stages/geometry/parallel.h"
#include "stages/subdivide/level_surface.h"

namespace phiz {
namespace {

constexpr std::size_t kGrain = 4096;
constexpr int kSlopeRounds = 12;
constexpr int kBridgeRounds = 60;
constexpr int kTurnRounds = 6;
constexpr double kSlopeToHeld = 0.3;  ///< of the slope: what is measured beside a hem meets it smoothly

DisplacementGraph build_control_graph(const SubdivisionHierarchy& hierarchy,
                                      const std::vector<Eigen::Vector3d>& positions) {
  const int count = hierarchy.vertex_count(0);
  const HalfEdgeMesh mesh(hierarchy.triangles(0), count);
  DisplacementGraph graph;
  graph.offsets.push_back(0);
  graph.to_old.assign(count, std::numeric_limits<double>::infinity());
  for (int v = 0; v < count; ++v) {
    double sum = 0;
    const std::vector<int> ring = mesh.ring(v);
    for (const int neighbour : ring) {
      graph.neighbours.push_back(neighbour);
      graph.lengths.push_back((positions[neighbour] - positions[v]).norm());
      sum += graph.lengths.back();
    }
    graph.spacings.push_back(ring.empty() ? 0.0 : sum / static_cast<double>(ring.size()));
    graph.offsets.push_back(static_cast<int>(graph.neighbours.size()));
  }
  return graph;
}

struct Move {
  int vertex = 0;
  double by = 0;
};

/// How far a value lies from the band around its neighbour's: > 0 too high, < 0 too low, 0 inside.
double excess(double value, double other, double allowed) {
  const double difference = value - other;
  return difference > allowed ? difference - allowed : difference < -allowed ? difference + allowed : 0.0;
}

}  // namespace

DisplacementGraph build_displacement_graph(const SubdivisionHierarchy& hierarchy, int level,
                                           const std::vector<Eigen::Vector3d>& positions) {
  if (level == 0) return build_control_graph(hierarchy, positions);
  const std::vector<SubdivisionHierarchy::Ring>& rings = hierarchy.rings(level);
  const int first = first_displaced(hierarchy, level);
  DisplacementGraph graph;
  graph.offsets.resize(rings.size() + 1);
  for (std::size_t i = 0; i < rings.size(); ++i)
    graph.offsets[i + 1] = graph.offsets[i] + (rings[i][4] < 0 ? 2 : 4);
  graph.neighbours.resize(graph.offsets.back());
  graph.lengths.resize(graph.offsets.back());
  graph.spacings.resize(rings.size());
  graph.to_old.resize(rings.size());
  parallel_for(rings.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const int degree = rings[i][4] < 0 ? 4 : 6;
      double sum = 0, to_old = std::numeric_limits<double>::infinity();
      int next = graph.offsets[i];
      for (int k = 0; k < degree; ++k) {
        const double length = (positions[rings[i][k]] - positions[first + i]).norm();
        sum += length;
        if (k == 0 || k == 3) {
          to_old = std::min(to_old, length);
        } else {
          graph.neighbours[next] = rings[i][k] - first;
          graph.lengths[next++] = length;
        }
      }
      graph.spacings[i] = sum / degree;
      graph.to_old[i] = to_old;
    }
  });
  return graph;
}

void reject_spikes(const DisplacementGraph& graph, double max_slope, DisplacementField& field) {
  const auto measured = [&](int v) { return field.states[v] == DisplacementField::kMeasured; };
  /// Whether every measured neighbour, and at least three of them, is too far from v.
  const auto stands_alone = [&](int v) {
    int neighbours = 0;
    for (int i = graph.offsets[v]; i < graph.offsets[v + 1]; ++i) {
      const int n = graph.neighbours[i];
      if (!measured(n)) continue;
      if (excess(field.values[v], field.values[n], max_slope * graph.lengths[i]) == 0) return false;
      ++neighbours;
    }
    return neighbours >= 3;
  };
  std::vector<char> alone(graph.vertex_count(), 0);
  for (int v = 0; v < graph.vertex_count(); ++v) alone[v] = measured(v) && stands_alone(v);
  for (int v = 0; v < graph.vertex_count(); ++v) {
    if (!alone[v]) continue;
    const auto begin = graph.neighbours.begin() + graph.offsets[v];
    const auto end = graph.neighbours.begin() + graph.offsets[v + 1];
    if (std::any_of(begin, end, [&](int n) { return alone[n] != 0; })) continue;
    field.values[v] = 0;
    field.states[v] = DisplacementField::kUnknown;
  }
}

void cap_slopes(const DisplacementGraph& graph, double max_slope, DisplacementField& field) {
  const auto measured = [&](int v) { return field.states[v] == DisplacementField::kMeasured; };
  std::vector<int> active;
  for (int v = 0; v < graph.vertex_count(); ++v) {
    if (!measured(v)) continue;
    const double allowed = max_slope * graph.to_old[v];
    field.values[v] = std::clamp(field.values[v], -allowed, allowed);
    active.push_back(v);
  }
  std::vector<int> conflicts(graph.vertex_count(), 0);
  std::vector<Move> moves;
  std::vector<char> touched(graph.vertex_count(), 0);
  for (int round = 0; round < kSlopeRounds && !active.empty(); ++round) {
    const auto excess_at = [&](int v, int i) {
      const int n = graph.neighbours[i];
      const bool held = field.states[n] == DisplacementField::kHeld;
      const double allowed = (held ? kSlopeToHeld : 1.0) * max_slope * graph.lengths[i];
      return held || measured(n) ? excess(field.values[v], field.values[n], allowed) : 0.0;
    };
    std::vector<int> offenders;
    for (const int v : active) {
      conflicts[v] = 0;
      for (int i = graph.offsets[v]; i < graph.offsets[v + 1]; ++i) conflicts[v] += excess_at(v, i) != 0;
      if (conflicts[v] > 0) offenders.push_back(v);
    }
    moves.clear();
    for (const int v : offenders) {
      double sum = 0;
      for (int i = graph.offsets[v]; i < graph.offsets[v + 1]; ++i) {
        const double too_far = excess_at(v, i);
        if (too_far == 0) continue;
        sum += too_far * conflicts[v] / (conflicts[v] + conflicts[graph.neighbours[i]]);
      }
      moves.push_back({v, -sum / conflicts[v]});
    }
    // Only what moved, and its neighbours, can be in conflict in the next round.
    active.clear();
    for (const Move& move : moves) {
      field.values[move.vertex] += move.by;
      const auto touch = [&](int v) {
        if (!touched[v] && measured(v)) touched[v] = 1, active.push_back(v);
      };
      touch(move.vertex);
      for (int i = graph.offsets[move.vertex]; i < graph.offsets[move.vertex + 1]; ++i)
        touch(graph.neighbours[i]);
    }
    for (const int v : active) touched[v] = 0;
  }
}

void bridge_gaps(const DisplacementGraph& graph, int rings, DisplacementField& field) {
  // Ring by ring outwards from what was measured.
  std::vector<int> gap;
  std::size_t ring_begin = 0;
  for (int ring = 0; ring < rings; ++ring) {
    const std::size_t ring_end = gap.size();
    const auto reach = [&](int v) {
      for (int i = graph.offsets[v]; i < graph.offsets[v + 1]; ++i) {
        const int n = graph.neighbours[i];
        if (field.states[n] != DisplacementField::kUnknown) continue;
        field.states[n] = DisplacementField::kBridged;
        gap.push_back(n);
      }
    };
    if (ring == 0) {
      for (int v = 0; v < graph.vertex_count(); ++v)
        if (field.states[v] == DisplacementField::kMeasured) reach(v);
    } else {
      for (std::size_t g = ring_begin; g < ring_end; ++g) reach(gap[g]);
    }
    ring_begin = ring == 0 ? 0 : ring_end;
  }
  // Weights fall with distance; everything outside the gap keeps its value.
  const auto weight = [&](int i) { return 1 / std::max(graph.lengths[i], 1e-9); };
  std::vector<double> next(gap.size());
  for (int round = 0; round < kBridgeRounds; ++round) {
    double largest_change = 0, largest = 0;
    for (std::size_t g = 0; g < gap.size(); ++g) {
      const int v = gap[g];
      double sum = 0, weights = 0;
      for (int i = graph.offsets[v]; i < graph.offsets[v + 1]; ++i) {
        sum += weight(i) * field.values[graph.neighbours[i]];
        weights += weight(i);
      }
      next[g] = sum / weights;
      largest_change = std::max(largest_change, std::abs(next[g] - field.values[v]));
      largest = std::max(largest, std::abs(next[g]));
    }
    for (std::size_t g = 0; g < gap.size(); ++g) field.values[gap[g]] = next[g];
    if (largest_change <= 1e-4 * largest) break;
  }
}

void limit_turns(std::span<const Eigen::Vector3i> triangles, std::span<const Eigen::Vector3d> positions,
                 std::span<const Eigen::Vector3d> normals, double least_turn_dot, DisplacementField& field) {
  const int first = static_cast<int>(positions.size() - normals.size());
  const auto displaced = [&](int v) -> Eigen::Vector3d {
    return v < first ? positions[v] : positions[v] + field.values[v - first] * normals[v - first];
  };
  std::vector<char> turned(triangles.size());
  for (int round = 0;; ++round) {  // every round behind kTurnRounds makes a value 0: it ends
    parallel_for(triangles.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        const int a = triangles[t][0], b = triangles[t][1], c = triangles[t][2];
        const Eigen::Vector3d before = (positions[b] - positions[a]).cross(positions[c] - positions[a]);
        const Eigen::Vector3d at = displaced(a);
        const Eigen::Vector3d after = (displaced(b) - at).cross(displaced(c) - at);
        turned[t] = before.dot(after) < least_turn_dot * before.norm() * after.norm();
      }
    });
    std::vector<char> shrink(normals.size(), 0);
    bool any = false;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      if (!turned[t]) continue;
      for (const int v : triangles[t])
        if (v >= first && field.values[v - first] != 0) shrink[v - first] = any = true;
    }
    if (!any) return;
    for (std::size_t i = 0; i < shrink.size(); ++i)
      if (shrink[i]) {
        field.values[i] *= round < kTurnRounds ? 0.5 : 0.0;
        if (field.states[i] == DisplacementField::kMeasured) field.states[i] = DisplacementField::kBridged;
      }
  }
}

}  // namespace phiz
