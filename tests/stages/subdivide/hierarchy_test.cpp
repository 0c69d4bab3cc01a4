#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "stages/geometry/error.h"
#include "stages/geometry/half_edge.h"
#include "stages/geometry/parallel.h"
#include "stages/subdivide/subdivide.h"
#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using Points = std::vector<Eigen::Vector3d>;

Points to_double(const std::vector<Eigen::Vector3f>& points) {
  Points result;
  for (const Eigen::Vector3f& p : points) result.push_back(p.cast<double>());
  return result;
}

SubdivisionHierarchy subdivide(const TriangleMesh& mesh, int levels) {
  return SubdivisionHierarchy(mesh.triangles, static_cast<int>(mesh.vertex_count()), levels);
}

std::map<int, double> row_of(const SubdivisionHierarchy& hierarchy, int level, int row) {
  const auto& stencils = hierarchy.stencils(level);
  std::map<int, double> result;
  for (int i = stencils.offsets[row]; i < stencils.offsets[row + 1]; ++i)
    result[stencils.vertices[i]] = stencils.weights[i];
  return result;
}

double largest_distance(const Points& a, const Points& b) {
  double largest = a.size() == b.size() ? 0 : 1e300;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

TEST(SubdivisionHierarchy, EveryRowSumsToExactlyOneAndNamesNoVertexTwice) {
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    SCOPED_TRACE(name);
    const SubdivisionHierarchy hierarchy = subdivide(mesh, 2);
    for (int level = 1; level <= 2; ++level) {
      const auto& stencils = hierarchy.stencils(level);
      ASSERT_EQ(static_cast<int>(stencils.offsets.size()) - 1,
                hierarchy.vertex_count(level) - hierarchy.vertex_count(level - 1));
      for (std::size_t row = 0; row + 1 < stencils.offsets.size(); ++row) {
        double sum = 0;
        std::set<int> named;
        for (int i = stencils.offsets[row]; i < stencils.offsets[row + 1]; ++i) {
          sum += stencils.weights[i];
          EXPECT_LT(stencils.vertices[i], hierarchy.vertex_count(level - 1));
          EXPECT_TRUE(named.insert(stencils.vertices[i]).second);
          EXPECT_NE(stencils.weights[i], 0);
        }
        EXPECT_EQ(sum, 1.0);
      }
    }
  }
}

TEST(SubdivisionHierarchy, LevelsAreManifoldsWithTheTopologyOfTheControlMesh) {
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    SCOPED_TRACE(name);
    const SubdivisionHierarchy hierarchy = subdivide(mesh, 2);
    HalfEdgeMesh coarse(hierarchy.triangles(0), hierarchy.vertex_count(0));
    for (int level = 1; level <= 2; ++level) {
      const HalfEdgeMesh fine(hierarchy.triangles(level), hierarchy.vertex_count(level));
      EXPECT_EQ(fine.triangle_count(), 4 * coarse.triangle_count());
      EXPECT_EQ(fine.vertex_count(), coarse.vertex_count() + coarse.edge_count());
      EXPECT_EQ(fine.border_loops().size(), coarse.border_loops().size());
      for (int v = 0; v < fine.vertex_count(); ++v) {
        const bool old = v < coarse.vertex_count();
        const int expected = old ? coarse.valence(v) : fine.is_border_vertex(v) ? 4 : 6;
        EXPECT_EQ(fine.valence(v), expected);
      }
      coarse = fine;
    }
  }
}

TEST(SubdivisionHierarchy, VertexAndTriangleOrderIsTheDocumentedOne) {
  const TriangleMesh mesh = test::disk(9, 2);
  const SubdivisionHierarchy hierarchy = subdivide(mesh, 1);
  const HalfEdgeMesh coarse(mesh.triangles, static_cast<int>(mesh.vertex_count()));
  for (int h = 0; h < coarse.half_edge_count(); ++h) {
    const Eigen::Vector2i parents = hierarchy.parents(1, coarse.vertex_count() + coarse.edge(h));
    EXPECT_EQ(parents.minCoeff(), std::min(coarse.from(h), coarse.to(h)));
    EXPECT_EQ(parents.maxCoeff(), std::max(coarse.from(h), coarse.to(h)));
  }
  for (int v = 0; v < coarse.vertex_count(); ++v) EXPECT_EQ(hierarchy.parents(1, v), Eigen::Vector2i(v, v));
  for (int t = 0; t < coarse.triangle_count(); ++t) {
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3i& corner = hierarchy.triangles(1)[4 * t + i];
      EXPECT_EQ(corner[0], coarse.from(3 * t + i));
      EXPECT_EQ(corner[1], coarse.vertex_count() + coarse.edge(3 * t + i));
      EXPECT_EQ(corner[2], coarse.vertex_count() + coarse.edge(coarse.prev(3 * t + i)));
      EXPECT_EQ(hierarchy.triangles(1)[4 * t + 3][i], coarse.vertex_count() + coarse.edge(3 * t + i));
    }
  }
}

TEST(SubdivisionHierarchy, RingsAreThoseOfTheHalfEdges) {
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    SCOPED_TRACE(name);
    const SubdivisionHierarchy hierarchy = subdivide(mesh, 2);
    for (int level = 1; level <= 2; ++level) {
      const HalfEdgeMesh fine(hierarchy.triangles(level), hierarchy.vertex_count(level));
      const int first = hierarchy.vertex_count(level - 1);
      for (int v = first; v < fine.vertex_count(); ++v) {
        std::vector<int> ring(hierarchy.rings(level)[v - first].begin(),
                              hierarchy.rings(level)[v - first].end());
        EXPECT_EQ(fine.is_border_vertex(v), ring[4] == -1);
        EXPECT_EQ(fine.is_border_vertex(v), ring[5] == -1);
        if (fine.is_border_vertex(v)) ring.resize(4);
        const std::vector<int> expected = fine.ring(v);
        const auto start = std::find(ring.begin(), ring.end(), expected[0]);
        ASSERT_NE(start, ring.end());
        std::rotate(ring.begin(), start, ring.end());
        EXPECT_EQ(ring, expected);
      }
    }
  }
}

TEST(Butterfly, RegularInteriorRowsAreTheEightPointStencil) {
  const SubdivisionHierarchy hierarchy = subdivide(test::torus(12, 7), 1);
  for (int row = 0; row < hierarchy.vertex_count(1) - hierarchy.vertex_count(0); ++row) {
    std::vector<double> weights;
    for (const auto& [vertex, weight] : row_of(hierarchy, 1, row)) weights.push_back(weight);
    std::sort(weights.begin(), weights.end());
    const double w = -1.0 / 16;
    EXPECT_EQ(weights, (std::vector<double>{w, w, w, w, 0.125, 0.125, 0.5, 0.5}));
  }
}

TEST(Butterfly, BorderRowsAreTheFourPointRuleAlongIt) {
  const TriangleMesh mesh = test::disk(9, 2);
  const SubdivisionHierarchy hierarchy = subdivide(mesh, 1);
  const HalfEdgeMesh coarse(mesh.triangles, static_cast<int>(mesh.vertex_count()));
  const std::vector<int> loop = coarse.border_loops()[0];
  const int n = static_cast<int>(loop.size());
  for (int i = 0; i < n; ++i) {
    const std::map<int, double> row = row_of(hierarchy, 1, coarse.edge(coarse.outgoing(loop[i])));
    EXPECT_EQ(row, (std::map<int, double>{{loop[(i + n - 1) % n], -1.0 / 16},
                                          {loop[i], 9.0 / 16},
                                          {loop[(i + 1) % n], 9.0 / 16},
                                          {loop[(i + 2) % n], -1.0 / 16}}));
  }
}

TEST(Butterfly, ExtraordinaryRowsAreTheirRules) {
  for (const int valence : {3, 4, 5, 7, 9, 24}) {
    SCOPED_TRACE(valence);
    const TriangleMesh mesh = test::disk(valence, 2);
    const SubdivisionHierarchy hierarchy = subdivide(mesh, 2);
    const HalfEdgeMesh coarse(hierarchy.triangles(1),
                              hierarchy.vertex_count(1));  // all round the centre is regular
    const std::vector<int> ring = coarse.ring(0);
    int h = coarse.outgoing(0);
    for (int i = 0; i < valence; ++i, h = coarse.rotate(h)) {
      const std::map<int, double> row = row_of(hierarchy, 2, coarse.edge(h));
      for (int j = 0; j < valence; ++j) {
        const double turn = 2 * std::acos(-1.0) * j / valence;
        double expected = (0.25 + std::cos(turn) + 0.5 * std::cos(2 * turn)) / valence;
        if (valence == 3) expected = j == 0 ? 5.0 / 12 : -1.0 / 12;
        if (valence == 4) expected = j == 0 ? 3.0 / 8 : j == 2 ? -1.0 / 8 : 0;
        const auto found = row.find(ring[(i + j) % valence]);
        EXPECT_NEAR(found == row.end() ? 0 : found->second, expected, 1e-12);
      }
      EXPECT_NEAR(row.at(0), 0.75, 1e-12);
    }
  }
}

TEST(Butterfly, BetweenTwoExtraordinaryVerticesStandsTheMeanOfBothRules) {
  const TriangleMesh mesh = test::icosphere(0);  // all of valence 5
  const SubdivisionHierarchy hierarchy = subdivide(mesh, 1);
  for (int row = 0; row < 30; ++row) {
    const Eigen::Vector2i parents = hierarchy.parents(1, 12 + row);
    const double s0 = (0.25 + 1 + 0.5) / 5;
    EXPECT_NEAR(row_of(hierarchy, 1, row).at(parents[0]), 0.5 * (0.75 + s0), 1e-12);
    EXPECT_NEAR(row_of(hierarchy, 1, row).at(parents[1]), 0.5 * (0.75 + s0), 1e-12);
  }
}

TEST(Butterfly, BorderFansReproduceTheirHalfDisk) {
  // A fan of k triangles over a half-disk, split once so that all round its centre is regular: the rule at
  // the centre halves x and y, the linear functions.
  for (int k = 2; k <= 9; ++k) {
    SCOPED_TRACE(k);
    std::vector<Eigen::Vector3i> fan;
    Points points{Eigen::Vector3d::Zero()};
    for (int i = 0; i <= k; ++i) {
      const double angle = std::acos(-1.0) * i / k;
      points.emplace_back(2 * std::cos(angle), 2 * std::sin(angle), 0);
      if (i > 0) fan.emplace_back(0, i, i + 1);
    }
    const SubdivisionHierarchy hierarchy(fan, k + 2, 2);
    for (int v = k + 2; v < hierarchy.vertex_count(1); ++v) {
      const Eigen::Vector2i parents = hierarchy.parents(1, v);
      points.push_back(0.5 * (points[parents[0]] + points[parents[1]]));
    }
    int checked = 0;
    for (int v = hierarchy.vertex_count(1); v < hierarchy.vertex_count(2); ++v) {
      const Eigen::Vector2i parents = hierarchy.parents(2, v);
      if (parents.minCoeff() != 0) continue;
      Eigen::Vector3d fine = Eigen::Vector3d::Zero();
      for (const auto& [vertex, weight] : row_of(hierarchy, 2, v - hierarchy.vertex_count(1)))
        fine += weight * points[vertex];
      EXPECT_LT((fine - 0.5 * points[parents.maxCoeff()]).norm(), 1e-12);
      ++checked;
    }
    EXPECT_EQ(checked, k + 1);
  }
}

/// Sheared so that all three edge directions count alike.
Points sheared_grid(int n, const std::function<double(double, double)>& height) {
  Points points;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double x = i - 0.5 * j, y = std::sqrt(0.75) * j;
      points.emplace_back(x, y, height(x, y));
    }
  return points;
}

/// Largest error of the new vertices of one step against the function, `away` edges or more from the border.
double reproduction_error(int n, int away, const std::function<double(double, double)>& height) {
  const TriangleMesh mesh = test::open_grid(n, n);
  const SubdivisionHierarchy hierarchy = subdivide(mesh, 1);
  const Points fine = evaluate_surface(hierarchy, sheared_grid(n, height), {}, 1);
  double largest = 0;
  for (int v = (n + 1) * (n + 1); v < hierarchy.vertex_count(1); ++v) {
    bool inside = true;
    for (const int parent : hierarchy.parents(1, v)) {
      const int i = parent % (n + 1), j = parent / (n + 1);
      inside = inside && std::min({i, j, n - i, n - j}) >= away;
    }
    const double u = (fine[v].x() + 0.5 * fine[v].y() / std::sqrt(0.75)), w = fine[v].y() / std::sqrt(0.75);
    if (!inside || std::min({u, w, n - u, n - w}) < 0) continue;
    largest = std::max(largest, std::abs(fine[v].z() - height(fine[v].x(), fine[v].y())));
  }
  return largest;
}

TEST(Butterfly, ReproducesCubicsInsideRegularGrids) {
  for (int degree = 0; degree <= 3; ++degree)
    for (int power = 0; power <= degree; ++power)
      EXPECT_LT(
          reproduction_error(
              8, 1, [&](double x, double y) { return std::pow(x, power) * std::pow(y, degree - power); }),
          1e-10)
          << "x^" << power << " y^" << degree - power;
  EXPECT_GT(reproduction_error(8, 1, [](double x, double y) { return x * x * y * y; }),
            0.01);  // but not quartics
}

TEST(Butterfly, ReproducesLinearFunctionsUpToTheSidesOfRegularGrids) {
  // Between the corners of the grid, which are no part of a straight border.
  const int n = 8;
  const TriangleMesh mesh = test::open_grid(n, n);
  const SubdivisionHierarchy hierarchy = subdivide(mesh, 1);
  const Points coarse = sheared_grid(n, [](double x, double y) { return 3 - x + 2 * y; });
  const Points fine = evaluate_surface(hierarchy, coarse, {}, 1);
  int on_border = 0;
  for (int v = (n + 1) * (n + 1); v < hierarchy.vertex_count(1); ++v) {
    const Eigen::Vector2i parents = hierarchy.parents(1, v);
    bool at_corner = false;
    for (const int parent : parents) {
      const int i = parent % (n + 1), j = parent / (n + 1);
      at_corner = at_corner || (std::min(i, n - i) < 2 && std::min(j, n - j) < 2);
    }
    if (at_corner) continue;
    EXPECT_LT((fine[v] - 0.5 * (coarse[parents[0]] + coarse[parents[1]])).norm(), 1e-10);
    on_border += hierarchy.rings(1)[v - (n + 1) * (n + 1)][4] < 0;
  }
  EXPECT_EQ(on_border, 16);
}

TEST(EvaluateSurface, AffineImagesCommuteAndPlanesStayPlanes) {
  test::Random& random = test::random();
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    SCOPED_TRACE(name);
    const SubdivisionHierarchy hierarchy = subdivide(mesh, 3);
    Eigen::Affine3d map;
    for (double& x : map.matrix().topRows<3>().reshaped()) x = random.normal();
    Points control = to_double(mesh.positions), image, flat;
    for (const Eigen::Vector3d& p : control) {
      image.push_back(map * p);
      flat.emplace_back(p.x(), p.y(), 0.3 * p.x() - 1.7 * p.y() + 5);
    }
    Points fine = evaluate_surface(hierarchy, control, {}, 3);
    for (Eigen::Vector3d& p : fine) p = map * p;
    EXPECT_LT(largest_distance(fine, evaluate_surface(hierarchy, image, {}, 3)), 1e-12);
    for (const Eigen::Vector3d& p : evaluate_surface(hierarchy, flat, {}, 3))
      EXPECT_NEAR(p.z(), 0.3 * p.x() - 1.7 * p.y() + 5, 1e-12);
  }
}

TEST(EvaluateSurface, KeepsOldVertices) {
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    SCOPED_TRACE(name);
    const SubdivisionHierarchy hierarchy = subdivide(mesh, 3);
    const Points control = to_double(mesh.positions);
    Points finest = evaluate_surface(hierarchy, control, {}, 3);
    for (int level = 2; level >= 0; --level) {
      finest.resize(hierarchy.vertex_count(level));
      EXPECT_EQ(evaluate_surface(hierarchy, control, {}, level), finest);
    }
  }
}

TEST(EvaluateSurface, MirroredMeshesGiveMirroredSurfaces) {
  test::Random& random = test::random();
  for (const auto& [name, mesh] : test::mesh_zoo()) {
    SCOPED_TRACE(name);
    Points control = to_double(mesh.positions), mirrored;
    for (Eigen::Vector3d& p : control)
      p += 0.1 * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    for (const Eigen::Vector3d& p : control) mirrored.emplace_back(-p.x(), p.y(), p.z());
    TriangleMesh turned =
        mesh;  // the mirror image is counter-clockwise again when its triangles are turned over
    for (Eigen::Vector3i& t : turned.triangles) std::swap(t[1], t[2]);
    const SubdivisionHierarchy left = subdivide(mesh, 2), right = subdivide(turned, 2);
    const auto displaced = [](const SubdivisionHierarchy& hierarchy, const Points& points) {
      std::vector<std::vector<float>> displacements;
      for (int level = 0; level <= 2; ++level)
        displacements.emplace_back(hierarchy.vertex_count(level), 0.05f);
      for (int level = 1; level <= 2; ++level)
        std::fill_n(displacements[level].begin(), hierarchy.vertex_count(level - 1), 0.0f);
      return evaluate_surface(hierarchy, points, displacements, 2);
    };
    // Edges are numbered differently: find the mirror of a new vertex by its parents, level by level.
    std::vector<int> mirror(left.vertex_count(2));
    for (int v = 0; v < left.vertex_count(0); ++v) mirror[v] = v;
    for (int level = 1; level <= 2; ++level) {
      std::map<std::pair<int, int>, int> by_parents;
      for (int v = right.vertex_count(level - 1); v < right.vertex_count(level); ++v) {
        const Eigen::Vector2i p = right.parents(level, v);
        by_parents[{p.minCoeff(), p.maxCoeff()}] = v;
      }
      for (int v = left.vertex_count(level - 1); v < left.vertex_count(level); ++v) {
        const Eigen::Vector2i p = left.parents(level, v);
        mirror[v] = by_parents.at(std::minmax(mirror[p[0]], mirror[p[1]]));
      }
    }
    const Points a = displaced(left, control), b = displaced(right, mirrored);
    const bool has_area = name != "slivers";  // normals of needles are at the mercy of rounding
    for (std::size_t v = 0; has_area && v < a.size(); ++v)
      EXPECT_LT((Eigen::Vector3d(-a[v].x(), a[v].y(), a[v].z()) - b[mirror[v]]).norm(), 1e-9);
  }
}

TEST(EvaluateSurface, IsSmoothAtExtraordinaryVerticesAndAtTheBorder) {
  // Over finer and finer levels the normals of neighbouring triangles come together (C1), here measured as
  // the largest angle between the two triangles of an edge: it must keep shrinking.
  for (const auto& [name, mesh] : {test::NamedMesh{"disk_5x3", test::disk(5, 3)},
                                   {"disk_9x2", test::disk(9, 2)},
                                   {"disk_4x3", test::disk(4, 3)},
                                   {"icosphere_0", test::icosphere(0)},
                                   {"open_grid_5x3", test::open_grid(5, 3)}}) {
    SCOPED_TRACE(name);
    Points control = to_double(mesh.positions);
    for (Eigen::Vector3d& p : control)
      if (name != "icosphere_0") p.z() = 0.3 * p.x() * p.x() - 0.2 * p.x() * p.y() - 0.25 * p.y() * p.y();
    const SubdivisionHierarchy hierarchy = subdivide(mesh, 5);
    std::vector<double> largest_turn;
    for (int level = 3; level <= 5; ++level) {
      const Points points = evaluate_surface(hierarchy, control, {}, level);
      const HalfEdgeMesh half_edges(hierarchy.triangles(level), hierarchy.vertex_count(level));
      const auto normal = [&](int t) {
        const Eigen::Vector3i& v = hierarchy.triangles(level)[t];
        return (points[v[1]] - points[v[0]]).cross(points[v[2]] - points[v[0]]).normalized();
      };
      double largest = 0;
      for (int h = 0; h < half_edges.half_edge_count(); ++h)
        if (!half_edges.is_border_edge(h))
          largest = std::max(largest, (normal(h / 3) - normal(half_edges.twin(h) / 3)).norm());
      largest_turn.push_back(largest);
    }
    EXPECT_LT(largest_turn[1], 0.75 * largest_turn[0]);
    EXPECT_LT(largest_turn[2], 0.75 * largest_turn[1]);
  }
}

TEST(EvaluateSurface, RefusesDisplacementsOfAnotherSize) {
  const TriangleMesh mesh = test::icosphere(0);
  const SubdivisionHierarchy hierarchy = subdivide(mesh, 1);
  const std::vector<std::vector<float>> wrong{{}, std::vector<float>(41, 0.0f)};
  EXPECT_THROW(evaluate_surface(hierarchy, to_double(mesh.positions), wrong, 1), InvalidInput);
  EXPECT_NO_THROW(evaluate_surface(hierarchy, to_double(mesh.positions), wrong, 0));
  EXPECT_THROW(evaluate_surface(hierarchy, to_double(mesh.positions), {}, 2), ContractViolation);
}

TEST(EvaluateUv, IsLinearInTheControlTriangles) {
  const TriangleMesh mesh = test::disk(9, 2);
  const SubdivisionHierarchy hierarchy = subdivide(mesh, 3);
  std::vector<Eigen::Vector2d> control;
  for (const Eigen::Vector3f& p : mesh.positions) control.push_back(p.head<2>().cast<double>());
  const std::vector<Eigen::Vector2d> uv = evaluate_uv(hierarchy, control, 3);
  ASSERT_EQ(static_cast<int>(uv.size()), hierarchy.vertex_count(3));
  // Each control triangle holds 64 triangles of the same shape: the same area and orientation.
  const auto area = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
  };
  for (std::size_t t = 0; t < hierarchy.triangles(3).size(); ++t) {
    const Eigen::Vector3i &fine = hierarchy.triangles(3)[t], &coarse = mesh.triangles[t / 64];
    EXPECT_NEAR(area(uv[fine[0]], uv[fine[1]], uv[fine[2]]),
                area(control[coarse[0]], control[coarse[1]], control[coarse[2]]) / 64, 1e-12);
  }
}

TEST(SubdivisionHierarchy, HasTheSameBitsAtAnyThreadCount) {
  const TriangleMesh mesh = test::icosphere(3);
  std::vector<std::vector<double>> weights;
  for (const int threads : {1, 2})
    with_threads(threads, [&] { weights.push_back(subdivide(mesh, 3).stencils(3).weights); });
  EXPECT_EQ(weights[0], weights[1]);
}

TEST(SubdivisionHierarchy, RefusesWhatIsNoManifoldAtAnyLevelCount) {
  const std::vector<Eigen::Vector3i> bad{{0, 1, 2}, {0, 1, 3}};
  EXPECT_THROW(SubdivisionHierarchy(bad, 4, 0), InvalidInput);
  EXPECT_THROW(SubdivisionHierarchy(bad, 4, 2), InvalidInput);
  EXPECT_THROW(SubdivisionHierarchy(bad, 4, -1), ContractViolation);
}

}  // namespace
}  // namespace phiz
