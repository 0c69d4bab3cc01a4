#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numbers>
#include <set>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "stages/geometry/surface_index.h"
#include "tests/stages/synth/synth_samples.h"
#include "tests/support/mesh_zoo.h"

namespace phiz::test {
namespace {

using Eigen::Vector3d;

constexpr double kRadians = std::numbers::pi / 180;

/// Two spheres of 60 and 25 mm; the small one stands before the large one and shadows it.
TriangleMesh two_spheres() {
  TriangleMesh mesh = icosphere(2);
  const int count = static_cast<int>(mesh.positions.size());
  const std::vector<Eigen::Vector3i> triangles = mesh.triangles;
  for (int v = 0; v < count; ++v) {
    mesh.positions.push_back(25 * mesh.positions[v] + Eigen::Vector3f(40, 10, 80));
    mesh.positions[v] *= 60;
  }
  for (const Eigen::Vector3i& t : triangles) mesh.triangles.push_back(t + Eigen::Vector3i::Constant(count));
  return mesh;
}

/// Does the open segment from `from` to `to` cross any triangle? Ends closer than `margin` to it do not
/// count.
bool is_blocked(const TriangleMesh& mesh, const Vector3d& from, const Vector3d& to, double margin) {
  const Vector3d way = to - from;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Vector3d a = mesh.positions[t[0]].cast<double>(), b = mesh.positions[t[1]].cast<double>(),
                   c = mesh.positions[t[2]].cast<double>();
    const Vector3d normal = (b - a).cross(c - a);
    const double facing = normal.dot(way);
    if (facing == 0) continue;
    const double along = normal.dot(a - from) / facing;
    if (along * way.norm() < margin || along > 1) continue;
    const Vector3d p = from + along * way;
    if (normal.dot((b - a).cross(p - a)) >= 0 && normal.dot((c - b).cross(p - b)) >= 0 &&
        normal.dot((a - c).cross(p - c)) >= 0) {
      return true;
    }
  }
  return false;
}

TEST(Scanner, WithoutErrorsEveryPointLiesOnTheSurface) {
  const SubjectBase& base = generic_base(2);
  const ScanTarget target = make_scan_target(base, make_subject(base, draw_recipe(5)));
  const PointCloud cloud = scan_surface(target, exact_scan(20'000), 5);
  EXPECT_EQ(cloud.size(), 20'000u);
  const SurfaceIndex index(target.mesh.positions, target.mesh.triangles);
  for (const Eigen::Vector3f& point : cloud.positions) {
    const auto hit = index.find_nearest(point.cast<double>(), 1.0);
    ASSERT_TRUE(hit.has_value());
    ASSERT_LT(hit->distance, 1e-4);
  }
}

TEST(Scanner, EveryPointIsSeenByCameraAndProjectorWithinTheirLimits) {
  const ScanTarget target = make_plain_target(two_spheres());
  ScanOptions options = exact_scan(3000);
  options.views = {{0, 0}};
  const PointCloud cloud = scan_surface(target, options, 3);
  ASSERT_GT(cloud.size(), 1000u);
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& p : target.mesh.positions) box.extend(p.cast<double>());
  const Vector3d camera = box.center() + Vector3d(0, 0, 800), projector = camera + Vector3d(250, 0, 0);
  const SurfaceIndex index(target.mesh.positions, target.mesh.triangles);
  for (const Eigen::Vector3f& point : cloud.positions) {
    const Vector3d p = point.cast<double>();
    const auto hit = index.find_nearest(p, 1.0);
    const Eigen::Vector3i& t = target.mesh.triangles[hit->triangle_idx];
    if (hit->weights.minCoeff() < 1e-4) continue;  // on an edge, the triangle is in doubt
    const Vector3d a = target.mesh.positions[t[0]].cast<double>();
    const Vector3d normal = (target.mesh.positions[t[1]].cast<double>() - a)
                                .cross(target.mesh.positions[t[2]].cast<double>() - a)
                                .normalized();
    ASSERT_GT(normal.dot((camera - p).normalized()), std::cos(72 * kRadians) - 1e-6);
    ASSERT_GT(normal.dot((projector - p).normalized()), std::cos(80 * kRadians) - 1e-6);
    ASSERT_FALSE(is_blocked(target.mesh, p + 1e-3 * normal, camera, 0.01));
    ASSERT_FALSE(is_blocked(target.mesh, p + 1e-3 * normal, projector, 0.01));
  }
}

TEST(Scanner, ShadowOfTheProjectorTakesPointsThatTheCameraSees) {
  const ScanTarget target = make_plain_target(two_spheres());
  ScanOptions options = exact_scan(100'000);
  options.views = {{0, 0}};
  options.spacing_mm = 2;
  const std::size_t with_shadow = scan_surface(target, options, 3).size();
  options.baseline_mm = 0;
  const std::size_t without = scan_surface(target, options, 3).size();
  EXPECT_LT(with_shadow, without);
  EXPECT_GT(with_shadow, without / 2);
}

TEST(Scanner, SameSeedSamePointsAtAnyThreadCount) {
  const SubjectBase& base = generic_base(2);
  const ScanTarget target = make_scan_target(base, base.positions);
  ScanOptions options;
  options.points = 10'000;
  PointCloud one, two;
  with_threads(1, [&] { one = scan_surface(target, options, 11); });
  with_threads(2, [&] { two = scan_surface(target, options, 11); });
  EXPECT_EQ(one.positions, two.positions);
  EXPECT_EQ(one.colours, two.colours);
  EXPECT_NE(scan_surface(target, options, 12).positions, one.positions);
}

TEST(Scanner, NoiseGrowsWithIncidenceAsSaid) {
  TriangleMesh wall;
  wall.positions = {{-100, -100, 0}, {100, -100, 0}, {100, 100, 0}, {-100, 100, 0}};
  wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  const ScanTarget target = make_plain_target(wall);
  for (const double azimuth : {0.0, -50.0}) {
    ScanOptions options = exact_scan(20'000);
    options.views = {{azimuth, 0}};
    options.distance_mm = 5000;  // nearly parallel rays
    options.noise_mm = 0.2;
    double sum = 0;
    const PointCloud cloud = scan_surface(target, options, 1);
    for (const Eigen::Vector3f& p : cloud.positions) sum += double{p.z()} * p.z();
    // sigma / cos along the ray is sigma along the normal
    EXPECT_NEAR(std::sqrt(sum / static_cast<double>(cloud.size())), 0.2, 0.01) << azimuth;
  }
}

TEST(Scanner, HairLosesSamplesAndScatters) {
  TriangleMesh ball = icosphere(3);
  for (Eigen::Vector3f& p : ball.positions) p *= 90;
  ScanTarget target = make_plain_target(ball);
  ScanOptions options;
  options.spacing_mm = 2;
  options.outlier_share = options.registration_deg = options.registration_mm = 0;
  const double bald = static_cast<double>(scan_surface(target, options, 1).size());
  target.materials.assign(target.materials.size(), ScanMaterial::kHair);
  const double hairy = static_cast<double>(scan_surface(target, options, 1).size());
  EXPECT_GT(hairy / bald, 0.05);
  EXPECT_LT(hairy / bald, 0.30);
}

TEST(Scanner, NothingLiesBelowTheCut) {
  const SubjectBase& base = generic_base(2);
  ScanOptions options = exact_scan(5000);
  options.cut = make_capture_plane(150, 4);
  const PointCloud cloud = scan_surface(make_scan_target(base, base.positions), options, 1);
  bool has_shoulders = false;
  for (const Eigen::Vector3f& p : cloud.positions) {
    EXPECT_GT(options.cut->normal.dot(p.cast<double>()), -150 - 1e-3);
    has_shoulders |= p.y() < -115;
  }
  EXPECT_TRUE(has_shoulders);
}

TEST(Scanner, ShouldersContinueTheNeckWithoutAGap) {
  const SubjectBase& base = generic_base(2);
  const ScanTarget target = make_scan_target(base, base.positions);
  const SubjectBase& same = base;
  std::map<std::pair<int, int>, int> edges;
  for (const Eigen::Vector3i& t : target.mesh.triangles) {
    for (int i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
  }
  for (const auto& [edge, uses] : edges) ASSERT_EQ(uses, 1);
  const std::size_t n = same.neck_loop.size();
  for (std::size_t i = 0; i < n; ++i) {
    const int a = same.neck_loop[i], b = same.neck_loop[(i + 1) % n];
    EXPECT_EQ(edges.count({a, b}) + edges.count({b, a}), 2u);
  }
}

TEST(ScanPose, IsARotationInTheUnitAndAllAxisOrientationsOccur) {
  std::set<std::vector<int>> orientations;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const Eigen::Matrix3d turn = draw_scan_pose(seed, 0.1).topLeftCorner<3, 3>() / 0.1;
    EXPECT_LT((turn.transpose() * turn - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_GT(turn.determinant(), 0);
    std::vector<int> rounded;  // 20 degrees off leave the largest entries where they were
    for (int i = 0; i < 9; ++i) rounded.push_back(static_cast<int>(std::lround(turn.data()[i])));
    orientations.insert(rounded);
  }
  EXPECT_EQ(orientations.size(), 24u);
}

TEST(Scanner, UnusableOptionsAreRefused) {
  const ScanTarget target = make_plain_target(icosphere(1));
  ScanOptions options;
  options.views.clear();
  EXPECT_THROW(scan_surface(target, options, 1), InvalidInput);
  options = {};
  options.noise_mm = -1;
  EXPECT_THROW(scan_surface(target, options, 1), InvalidInput);
  options = {};
  options.cut = Plane{Vector3d::UnitY(), 1000};
  EXPECT_THROW(scan_surface(target, options, 1), InvalidInput);
}

}  // namespace
}  // namespace phiz::test
