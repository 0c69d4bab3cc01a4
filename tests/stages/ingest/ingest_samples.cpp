#include "tests/stages/ingest/ingest_samples.h"

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>

#include "tests/stages/synth/synth_samples.h"
#include "tests/support/random.h"

namespace phiz::test {
namespace {

Eigen::Vector3d random_direction() {
  return Eigen::Vector3d(random().normal(), random().normal(), random().normal()).normalized();
}

void add_capsule(PointCloud& cloud, const Eigen::Vector3d& a, const Eigen::Vector3d& b, double radius_mm,
                 int count) {
  const double length = (b - a).norm();
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d out = random_direction();
    const Eigen::Vector3d along = (b - a) / length;
    if (random().uniform() * (length + 2 * radius_mm) < length) {
      const Eigen::Vector3d side = (out - out.dot(along) * along).normalized();
      cloud.positions.push_back((a + random().uniform() * (b - a) + radius_mm * side).cast<float>());
    } else {
      cloud.positions.push_back(((out.dot(along) > 0 ? b : a) + radius_mm * out).cast<float>());
    }
  }
}

}  // namespace

const ControlMesh& generic_head() {
  static const ControlMesh head = read_generic_head();
  return head;
}

const PointCloud& subject_scan(std::uint64_t seed) {
  static std::map<std::uint64_t, PointCloud> made;
  const auto found = made.find(seed);
  if (found != made.end()) return found->second;
  const SubjectBase& base = generic_base(2);
  const ScanTarget target = make_scan_target(base, make_subject(base, draw_recipe(seed, 0.7)));
  ScanOptions options;
  options.points = 25'000;
  options.cut = make_capture_plane(180, seed);
  return made.emplace(seed, scan_surface(target, options, seed)).first->second;
}

ScanFile make_scan(PointCloud points) {
  ScanFile scan;
  scan.points = std::move(points);
  return scan;
}

ScanFile posed(const PointCloud& cloud, const Eigen::Matrix4d& scan_from_truth) {
  ScanFile scan = make_scan(cloud);
  for (auto& p : scan.points.positions)
    p = (scan_from_truth * p.cast<double>().homogeneous()).head<3>().cast<float>();
  return scan;
}

PoseError pose_error(const IngestResult& result, const Eigen::Matrix4d& scan_from_truth) {
  const Eigen::Matrix4d delta = result.scan_from_head.inverse() * scan_from_truth;  // head from truth
  const Eigen::Matrix3d linear = delta.topLeftCorner<3, 3>();
  PoseError error;
  error.scale = std::cbrt(linear.determinant());
  error.turn_deg = Eigen::AngleAxisd(Eigen::Matrix3d(linear / error.scale)).angle() * 180 / std::numbers::pi;
  const Eigen::Vector3d middle(0, 0, 40);
  error.shift_mm = ((delta * middle.homogeneous()).head<3>() - middle).norm();
  return error;
}

PointCloud sphere_points(int count, double radius_mm) {
  PointCloud cloud;
  for (int i = 0; i < count; ++i) cloud.positions.push_back((radius_mm * random_direction()).cast<float>());
  return cloud;
}

PointCloud cube_points(int count, double side_mm) {
  PointCloud cloud;
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d p(random().uniform(-1, 1), random().uniform(-1, 1), random().uniform(-1, 1));
    p[i % 3] = i % 2 ? 1 : -1;
    cloud.positions.push_back((0.5 * side_mm * p).cast<float>());
  }
  return cloud;
}

PointCloud plane_points(int count, double side_mm) {
  PointCloud cloud;
  for (int i = 0; i < count; ++i)
    cloud.positions.push_back(
        (0.5 * side_mm * Eigen::Vector3d(random().uniform(-1, 1), random().uniform(-1, 1), 0)).cast<float>());
  return cloud;
}

PointCloud horse_points(int count) {
  PointCloud cloud;
  const auto add = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b, double radius, double share) {
    add_capsule(cloud, a, b, radius, static_cast<int>(share * count));
  };
  add({-70, 0, 0}, {70, 0, 0}, 40, 0.4);
  for (const double x : {-80.0, 80.0})
    for (const double z : {-22.0, 22.0}) add({x, -20, z}, {x, -150, z}, 10, 0.08);
  add({85, 20, 0}, {130, 100, 0}, 20, 0.13);
  add({130, 100, 0}, {175, 75, 0}, 15, 0.1);
  add({-105, 15, 0}, {-130, -60, 0}, 7, 0.05);
  return cloud;
}

}  // namespace phiz::test
