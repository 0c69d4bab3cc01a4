#include "stages/subdivide/displacement_field.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "stages/subdivide/level_surface.h"
#include "stages/subdivide/subdivide.h"
#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

/// The graph of a grid of unit cells.
DisplacementGraph grid_graph(int n) {
  const TriangleMesh mesh = test::open_grid(n, n);
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3f& p : mesh.positions) positions.push_back(n * p.cast<double>());
  return build_displacement_graph(SubdivisionHierarchy(mesh.triangles, (n + 1) * (n + 1), 0), 0, positions);
}

DisplacementField field_of(int count, double value, DisplacementField::State state) {
  DisplacementField field;
  field.values.assign(count, value);
  field.states.assign(count, state);
  return field;
}

double steepest(const DisplacementGraph& graph, const DisplacementField& field) {
  double result = 0;
  for (int v = 0; v < graph.vertex_count(); ++v)
    for (int i = graph.offsets[v]; i < graph.offsets[v + 1]; ++i)
      result =
          std::max(result, std::abs(field.values[v] - field.values[graph.neighbours[i]]) / graph.lengths[i]);
  return result;
}

TEST(DisplacementField, GraphOfAFinerLevelJoinsNewVerticesOnly) {
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    SCOPED_TRACE(name);
    const SubdivisionHierarchy hierarchy(mesh.triangles, static_cast<int>(mesh.vertex_count()), 1);
    std::vector<Eigen::Vector3d> control;
    for (const Eigen::Vector3f& p : mesh.positions) control.push_back(p.cast<double>());
    std::vector<Eigen::Vector3d> positions = control;
    refine_positions(hierarchy, 1, positions);
    const DisplacementGraph graph = build_displacement_graph(hierarchy, 1, positions);
    const int first = first_displaced(hierarchy, 1);
    ASSERT_EQ(graph.vertex_count() + first, hierarchy.vertex_count(1));
    for (int v = 0; v < graph.vertex_count(); ++v) {
      for (int i = graph.offsets[v]; i < graph.offsets[v + 1]; ++i) {
        const int n = graph.neighbours[i];
        EXPECT_NEAR(graph.lengths[i], (positions[first + v] - positions[first + n]).norm(), 1e-12);
        const auto begin = graph.neighbours.begin() + graph.offsets[n],
                   end = graph.neighbours.begin() + graph.offsets[n + 1];
        EXPECT_NE(std::find(begin, end, v), end);  // neighbours are mutual
      }
      const Eigen::Vector2i parents = hierarchy.parents(1, first + v);
      EXPECT_EQ(graph.to_old[v], std::min((positions[first + v] - positions[parents[0]]).norm(),
                                          (positions[first + v] - positions[parents[1]]).norm()));
    }
  }
}

TEST(DisplacementField, GentleSlopesAreNotTouched) {
  test::Random& random = test::random();
  const DisplacementGraph graph = grid_graph(10);
  DisplacementField field = field_of(graph.vertex_count(), 0, DisplacementField::kMeasured);
  for (double& value : field.values) value = random.uniform(0, 0.99);
  const std::vector<double> before = field.values;
  cap_slopes(graph, 1.0, field);
  EXPECT_EQ(field.values, before);
}

TEST(DisplacementField, SteepSlopesAreRelaxed) {
  test::Random& random = test::random();
  const DisplacementGraph graph = grid_graph(20);
  DisplacementField field = field_of(graph.vertex_count(), 0.5, DisplacementField::kMeasured);
  for (int spike = 0; spike < 15; ++spike)
    field.values[random.below(graph.vertex_count())] += random.normal() * 10;
  cap_slopes(graph, 1.0, field);
  EXPECT_LT(steepest(graph, field), 1.3);
}

TEST(DisplacementField, LoneSpikesAreTakenBackRidgesAreNot) {
  const int n = 8;
  const DisplacementGraph graph = grid_graph(n);
  DisplacementField field = field_of(graph.vertex_count(), 0.5, DisplacementField::kMeasured);
  const int spike = 2 * (n + 1) + 2;
  field.values[spike] = -40;
  for (int v = 0; v < graph.vertex_count(); ++v)
    if (v % (n + 1) == 6) field.values[v] = 5;  // a ridge: steep on both sides, but its vertices agree
  reject_spikes(graph, 1.0, field);
  for (int v = 0; v < graph.vertex_count(); ++v)
    EXPECT_EQ(field.states[v], v == spike ? DisplacementField::kUnknown : DisplacementField::kMeasured);
  EXPECT_EQ(field.values[spike], 0);
}

TEST(DisplacementField, UnmeasuredNeighboursDoNotHoldMeasuredOnes) {
  const DisplacementGraph graph = grid_graph(4);
  DisplacementField field = field_of(graph.vertex_count(), 0, DisplacementField::kUnknown);
  field.states[12] = DisplacementField::kMeasured;
  field.values[12] = 30;
  cap_slopes(graph, 1.0, field);
  EXPECT_EQ(field.values[12], 30);
}

TEST(DisplacementField, BridgesContinueLinearFunctions) {
  // Harmonic: over a hole in a linear slope on a regular grid the slope goes on.
  const int n = 12;
  const DisplacementGraph graph = grid_graph(n);
  DisplacementField field = field_of(graph.vertex_count(), 0, DisplacementField::kMeasured);
  for (int v = 0; v < graph.vertex_count(); ++v) {
    const int i = v % (n + 1), j = v / (n + 1);
    field.values[v] = 1.0 + 0.2 * i - 0.1 * j;
    if (i >= 5 && i <= 7 && j >= 5 && j <= 7)
      field.values[v] = 0, field.states[v] = DisplacementField::kUnknown;
  }
  bridge_gaps(graph, 2, field);
  for (int v = 0; v < graph.vertex_count(); ++v) {
    EXPECT_NEAR(field.values[v], 1.0 + 0.2 * (v % (n + 1)) - 0.1 * (v / (n + 1)), 0.01);
    EXPECT_NE(field.states[v], DisplacementField::kUnknown);
  }
}

TEST(DisplacementField, BridgesReachTheirRingsAndFallToZero) {
  const int n = 24;
  const DisplacementGraph graph = grid_graph(n);
  for (const int rings : {0, 1, 2, 4}) {
    DisplacementField field = field_of(graph.vertex_count(), 0, DisplacementField::kUnknown);
    for (int v = 0; v < graph.vertex_count(); ++v)
      if (v % (n + 1) == 0) field.values[v] = 3, field.states[v] = DisplacementField::kMeasured;
    bridge_gaps(graph, rings, field);
    for (int v = 0; v < graph.vertex_count(); ++v) {
      const int i = v % (n + 1), j = v / (n + 1);
      const auto expected = i == 0       ? DisplacementField::kMeasured
                            : i <= rings ? DisplacementField::kBridged
                                         : DisplacementField::kUnknown;
      EXPECT_EQ(field.states[v], expected);
      if (j > 8 && j < n - 8) {
        EXPECT_NEAR(field.values[v], i <= rings ? 3.0 * (rings + 1 - i) / (rings + 1) : 0.0, 0.02);
      }
    }
  }
}

TEST(DisplacementField, HeldVerticesStopABridge) {
  const int n = 6;
  const DisplacementGraph graph = grid_graph(n);
  DisplacementField field = field_of(graph.vertex_count(), 0, DisplacementField::kUnknown);
  for (int v = 0; v < graph.vertex_count(); ++v) {
    if (v % (n + 1) == 0) field.values[v] = 3, field.states[v] = DisplacementField::kMeasured;
    if (v % (n + 1) == 2) field.states[v] = DisplacementField::kHeld;
  }
  bridge_gaps(graph, 10, field);
  for (int v = 0; v < graph.vertex_count(); ++v)
    if (v % (n + 1) >= 2) {
      EXPECT_EQ(field.values[v], 0);
    } else if (v % (n + 1) == 1) {
      EXPECT_NEAR(field.values[v], 1.5, 0.5);
    }
}

/// A flat grid with its normals, all of whose vertices are displaced.
struct FlatGrid {
  explicit FlatGrid(int n)
      : mesh(test::open_grid(n, n)), normals(mesh.vertex_count(), Eigen::Vector3d::UnitZ()) {
    for (const Eigen::Vector3f& p : mesh.positions) positions.push_back(n * p.cast<double>());
  }
  double least_turn_dot(const DisplacementField& field) const {
    double least = 1;
    for (const Eigen::Vector3i& t : mesh.triangles) {
      Eigen::Vector3d at[3];
      for (int k = 0; k < 3; ++k) at[k] = positions[t[k]] + field.values[t[k]] * normals[t[k]];
      const Eigen::Vector3d before =
          (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]).normalized();
      least = std::min(least, (at[1] - at[0]).cross(at[2] - at[0]).normalized().dot(before));
    }
    return least;
  }
  TriangleMesh mesh;
  std::vector<Eigen::Vector3d> positions, normals;
};

TEST(DisplacementField, TurnsWithinTheLimitAreLeft) {
  const FlatGrid grid(8);
  DisplacementField field =
      field_of(static_cast<int>(grid.mesh.vertex_count()), 0, DisplacementField::kMeasured);
  for (double& value : field.values) value = test::random().uniform(-0.3, 0.3);
  const std::vector<double> before = field.values;
  limit_turns(grid.mesh.triangles, grid.positions, grid.normals, 0.5, field);
  EXPECT_EQ(field.values, before);
}

TEST(DisplacementField, NoTriangleTurnsBeyondTheLimitAndFarVerticesStay) {
  const FlatGrid grid(12);
  for (int trial = 0; trial < 20; ++trial) {
    DisplacementField field =
        field_of(static_cast<int>(grid.mesh.vertex_count()), 0, DisplacementField::kMeasured);
    for (double& value : field.values) value = test::random().uniform(-0.1, 0.1);
    const int spike = static_cast<int>(test::random().below(field.values.size()));
    field.values[spike] = test::random().uniform(-20, 20);
    const std::vector<double> before = field.values;
    limit_turns(grid.mesh.triangles, grid.positions, grid.normals, 0.5, field);
    EXPECT_GE(grid.least_turn_dot(field), 0.5 - 1e-12);
    for (std::size_t v = 0; v < before.size(); ++v)
      if ((grid.positions[v] - grid.positions[spike]).norm() > 4) {
        EXPECT_EQ(field.values[v], before[v]);
      }
  }
}

TEST(DisplacementField, NoCliffIsLeftAroundAWidePlateau) {
  const FlatGrid grid(30);
  DisplacementField field =
      field_of(static_cast<int>(grid.mesh.vertex_count()), 0, DisplacementField::kMeasured);
  for (std::size_t v = 0; v < field.values.size(); ++v)
    if ((grid.positions[v] - Eigen::Vector3d(15, 15, 0)).norm() < 11) field.values[v] = 40;
  limit_turns(grid.mesh.triangles, grid.positions, grid.normals, 0.5, field);
  EXPECT_GE(grid.least_turn_dot(field), 0.5 - 1e-12);
}

TEST(DisplacementField, AMeasuredValueBesideAHeldVertexKeepsToAGentleSlope) {
  const DisplacementGraph graph = grid_graph(6);
  DisplacementField field = field_of(graph.vertex_count(), 0, DisplacementField::kHeld);
  const int centre = graph.vertex_count() / 2;
  field.states[centre] = DisplacementField::kMeasured;
  field.values[centre] = 10;
  cap_slopes(graph, 0.7, field);
  double shortest = 1e9;
  for (int i = graph.offsets[centre]; i < graph.offsets[centre + 1]; ++i)
    shortest = std::min(shortest, graph.lengths[i]);
  EXPECT_LE(field.values[centre], 0.3 * 0.7 * shortest + 0.1);
  EXPECT_EQ(field.values[centre + 1], 0);
}

}  // namespace
}  // namespace phiz
