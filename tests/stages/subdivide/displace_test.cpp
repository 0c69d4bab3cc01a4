#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "stages/subdivide/subdivide.h"
#include "tests/support/mesh_zoo.h"

namespace phiz {
namespace {

using Points = std::vector<Eigen::Vector3d>;

constexpr double kRadius = 100;

Points scaled(const TriangleMesh& mesh, double scale) {
  Points result;
  for (const Eigen::Vector3f& p : mesh.positions) result.push_back(scale * p.cast<double>());
  return result;
}

/// Distance along the normal to the sphere about the origin, the nearer of the two crossings.
SurfaceMeasurement measure_sphere(const Eigen::Vector3d& position, const Eigen::Vector3d& normal, double) {
  const double along = position.dot(normal);
  const double square = along * along - position.squaredNorm() + kRadius * kRadius;
  if (square < 0) return {};
  return {along > 0 ? -along + std::sqrt(square) : -along - std::sqrt(square), 1};
}

struct Fixture {
  explicit Fixture(const TriangleMesh& mesh, int levels, double scale)
      : control(scaled(mesh, scale)),
        hierarchy(mesh.triangles, static_cast<int>(mesh.vertex_count()), levels),
        measurable(mesh.vertex_count(), true) {}
  DisplacedSurface displaced(const MeasureSurface& measure, const DisplacementOptions& options = {}) const {
    return displace(hierarchy, control, measurable, measure, options);
  }
  Points control;
  SubdivisionHierarchy hierarchy;
  std::vector<bool> measurable;
};

/// Something uneven that has holes.
SurfaceMeasurement measure_bumps(const Eigen::Vector3d& p, const Eigen::Vector3d&, double spacing) {
  if (std::sin(0.07 * p.x()) * std::cos(0.05 * p.y()) > 0.7) return {};
  return {0.2 * spacing * std::sin(0.11 * p.z() + 0.2 * p.x()), 0.8};
}

TEST(Displace, VerticesOfEveryLevelLieOnTheSphere) {
  const Fixture f(test::icosphere(1), 4, 0.97 * kRadius);
  const DisplacedSurface surface = f.displaced(measure_sphere);
  ASSERT_EQ(static_cast<int>(surface.positions.size()), f.hierarchy.vertex_count(4));
  for (const Eigen::Vector3d& p : surface.positions) EXPECT_NEAR(p.norm(), kRadius, 1e-5);
  EXPECT_NEAR(surface.rms_displacement_mm[0], 0.03 * kRadius, 1e-4);
  for (int level = 2; level <= 4; ++level)  // finer levels have less and less left to say
    EXPECT_LT(surface.rms_displacement_mm[level], 0.5 * surface.rms_displacement_mm[level - 1]);
  for (const auto& level : surface.confidences)
    EXPECT_TRUE(std::all_of(level.begin(), level.end(), [](int c) { return c == 255; }));
}

TEST(Displace, EvaluateSurfaceGivesTheSameBits) {
  for (const TriangleMesh& mesh :
       {test::icosphere(1), test::disk(5, 3), test::torus(12, 7), test::sliver_mesh()}) {
    const Fixture f(mesh, 3, kRadius);
    const DisplacedSurface surface = f.displaced(measure_bumps);
    const Points evaluated = evaluate_surface(f.hierarchy, f.control, surface.displacements_mm, 3);
    EXPECT_EQ(evaluated, surface.positions);
  }
}

TEST(Displace, GivesTheSameBitsAtAnyThreadCount) {
  const Fixture f(test::icosphere(2), 3, kRadius);
  std::vector<DisplacedSurface> surfaces;
  for (const int threads : {1, 2})
    with_threads(threads, [&] { surfaces.push_back(f.displaced(measure_bumps)); });
  EXPECT_EQ(surfaces[0].positions, surfaces[1].positions);
  EXPECT_EQ(surfaces[0].displacements_mm, surfaces[1].displacements_mm);
  EXPECT_EQ(surfaces[0].confidences, surfaces[1].confidences);
}

TEST(Displace, FinerLevelsInterpolateCoarserOnes) {
  const Fixture f(test::disk(9, 2), 3, kRadius);
  const DisplacedSurface surface = f.displaced(measure_bumps);
  for (int level = 1; level <= 3; ++level) {
    const auto& displacements = surface.displacements_mm[level];
    ASSERT_EQ(static_cast<int>(displacements.size()), f.hierarchy.vertex_count(level));
    ASSERT_EQ(surface.confidences[level].size(), displacements.size());
    for (int v = 0; v < f.hierarchy.vertex_count(level - 1); ++v) {
      EXPECT_EQ(displacements[v], 0.0f);
      EXPECT_EQ(surface.confidences[level][v], surface.confidences[level - 1][v]);
    }
  }
}

TEST(Displace, AsksOncePerVertexAtUnitNormalsWithTheMeshsSpacing) {
  const Fixture f(test::icosphere(1), 2, kRadius);
  std::atomic<int> asked = 0;
  std::atomic<bool> sensible = true;
  f.displaced([&](const Eigen::Vector3d& p, const Eigen::Vector3d& n, double spacing) {
    ++asked;
    const bool fine =
        std::abs(n.norm() - 1) < 1e-12 && n.dot(p.normalized()) > 0.95 && spacing > 10 && spacing < 65;
    if (!fine) sensible = false;
    return SurfaceMeasurement{};
  });
  EXPECT_EQ(asked, f.hierarchy.vertex_count(2));
  EXPECT_TRUE(sensible);
}

TEST(Displace, WithoutMeasurementsTheSurfaceIsTheSubdividedOne) {
  const Fixture f(test::torus(12, 7), 2, kRadius);
  const DisplacedSurface surface = f.displaced([](const Eigen::Vector3d&, const Eigen::Vector3d&, double) {
    return SurfaceMeasurement{7, 0};
  });
  EXPECT_EQ(surface.positions, evaluate_surface(f.hierarchy, f.control, {}, 2));
  for (const auto& level : surface.confidences)
    EXPECT_TRUE(std::all_of(level.begin(), level.end(), [](int c) { return c == 0; }));
}

TEST(Displace, MeasurementsThatAreNoNumbersCountAsNone) {
  const Fixture f(test::icosphere(1), 1, kRadius);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const SurfaceMeasurement& bad : {SurfaceMeasurement{nan, 1},
                                        {1, nan},
                                        {std::numeric_limits<double>::infinity(), 1},
                                        {1e300, 1},
                                        {1, -1}}) {
    const DisplacedSurface surface =
        f.displaced([&](const Eigen::Vector3d&, const Eigen::Vector3d&, double) { return bad; });
    EXPECT_EQ(surface.positions, evaluate_surface(f.hierarchy, f.control, {}, 1));
    EXPECT_EQ(*std::max_element(surface.confidences[0].begin(), surface.confidences[0].end()), 0);
  }
}

TEST(Displace, SmallHolesAreBridgedAndTheFarSideIsLeftAlone) {
  const Fixture f(test::icosphere(3), 1, 0.99 * kRadius);
  const auto measure = [](const Eigen::Vector3d& p, const Eigen::Vector3d& n, double spacing) {
    const bool hole = (p.normalized() - Eigen::Vector3d(1, 2, 3).normalized()).norm() < 0.2;
    return hole || p.z() < -40 ? SurfaceMeasurement{} : measure_sphere(p, n, spacing);
  };
  const DisplacedSurface surface = f.displaced(measure);
  int bridged = 0, invented = 0;
  for (int v = 0; v < f.hierarchy.vertex_count(0); ++v) {
    const Eigen::Vector3d p = f.control[v];
    const float d = surface.displacements_mm[0][v];
    const int confidence = surface.confidences[0][v];
    if (p.z() < -40) {
      EXPECT_TRUE(confidence == 0 || confidence == 128);
      EXPECT_TRUE(confidence == 128 || d == 0);  // beyond two rings nothing moves
      EXPECT_TRUE(d >= 0 && d < 0.01 * kRadius);
      invented += confidence == 0;
    } else if (confidence == 128) {  // the hole: all round it the displacement is the same
      EXPECT_NEAR(d, 0.01 * kRadius, 0.02);
      ++bridged;
    } else {
      EXPECT_EQ(confidence, 255);
    }
  }
  EXPECT_GT(bridged, 3);
  EXPECT_GT(invented, 50);
}

TEST(Displace, HeldVerticesAndThoseBetweenThemAndTheNextAreNotMeasured) {
  Fixture f(test::icosphere(2), 2, 0.98 * kRadius);
  for (std::size_t v = 0; v < f.control.size(); ++v) f.measurable[v] = f.control[v].y() < 20;
  DisplacementOptions options;
  options.bridge_rings = 50;
  const DisplacedSurface surface = f.displaced(measure_sphere, options);
  std::vector<char> held;
  for (const bool measurable : f.measurable) held.push_back(!measurable);
  for (int level = 0; level <= 2; ++level) {
    for (int v = static_cast<int>(held.size()); v < f.hierarchy.vertex_count(level); ++v) {
      const Eigen::Vector2i parents = f.hierarchy.parents(level, v);
      held.push_back(held[parents[0]] || held[parents[1]]);
    }
    for (std::size_t v = 0; v < held.size(); ++v) {
      EXPECT_EQ(surface.confidences[level][v] == 0, held[v] == 1);
      if (held[v]) {
        EXPECT_EQ(surface.displacements_mm[level][v], 0.0f);
      }
    }
  }
}

TEST(Displace, ConfidenceIsTheMeasurements) {
  const Fixture f(test::icosphere(0), 0, kRadius);
  for (const auto& [confidence, byte] : {std::pair{1.0, 255}, {0.6, 153}, {1e-9, 1}, {5.0, 255}}) {
    const DisplacedSurface surface =
        f.displaced([c = confidence](const Eigen::Vector3d&, const Eigen::Vector3d&, double) {
          return SurfaceMeasurement{1, c};
        });
    for (const int found : surface.confidences[0]) EXPECT_EQ(found, byte);
  }
}

TEST(Displace, ASpikeGivesWayAndItsSurroundingsStay) {
  const Fixture f(test::icosphere(3), 0, 0.99 * kRadius);
  const Eigen::Vector3d spike = f.control[100];
  const DisplacedSurface surface =
      f.displaced([&](const Eigen::Vector3d& p, const Eigen::Vector3d& n, double spacing) {
        SurfaceMeasurement m = measure_sphere(p, n, spacing);
        if (p == spike) m.displacement_mm += 60;
        return m;
      });
  for (std::size_t v = 0; v < f.control.size(); ++v) {
    EXPECT_NEAR(surface.displacements_mm[0][v], 0.01 * kRadius, 1e-3);
    EXPECT_EQ(surface.confidences[0][v], f.control[v] == spike ? 128 : 255);
  }
}

}  // namespace
}  // namespace phiz
