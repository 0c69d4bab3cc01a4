#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <random>

#include "formats/scan_file.h"
#include "formats/triangle_mesh.h"
#include "tests/bench/areas.h"
#include "tests/bench/surface_error.h"

namespace phiz::bench {
namespace {

constexpr int kFewTurns = 1, kManyTurns = 8;
constexpr double kMaxTiltDeg = 20, kMaxOffsetMm = 1500;

class Turner {
 public:
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }

  /// One of the 24 ways a cube fits on itself, tilted by up to 20 degrees, in mm, cm, m or inches, moved.
  Eigen::Matrix4d draw(double mm_per_scan_unit) {
    constexpr double kQuarter = std::numbers::pi / 2;
    const auto quarter = [&](const Eigen::Vector3d& axis) {
      return Eigen::AngleAxisd(kQuarter * std::floor(uniform(0, 4)), axis);
    };
    const Eigen::Vector3d side = sides_[static_cast<std::size_t>(uniform(0, 6))];
    const Eigen::Quaterniond up = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitY(), side);
    const Eigen::Vector3d axis =
        Eigen::Vector3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1) + 1e-9).normalized();
    const Eigen::AngleAxisd tilt(uniform(-1, 1) * kMaxTiltDeg * std::numbers::pi / 180, axis);
    const Eigen::Matrix3d rotation = tilt.toRotationMatrix() * up.toRotationMatrix() *
                                     quarter(Eigen::Vector3d::UnitY()).toRotationMatrix();
    constexpr std::array<double, 4> kUnitsMm = {1, 10, 1000, 25.4};
    const double unit_mm = kUnitsMm[static_cast<std::size_t>(uniform(0, 4))];
    Eigen::Matrix4d turned_from_scan = Eigen::Matrix4d::Identity();
    turned_from_scan.topLeftCorner<3, 3>() = mm_per_scan_unit / unit_mm * rotation;
    for (int i = 0; i < 3; ++i) turned_from_scan(i, 3) = uniform(-kMaxOffsetMm, kMaxOffsetMm) / unit_mm;
    return turned_from_scan;
  }

 private:
  std::mt19937_64 random_{19990630};
  const std::array<Eigen::Vector3d, 6> sides_ = {Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitX(),
                                                 Eigen::Vector3d::UnitY(), -Eigen::Vector3d::UnitY(),
                                                 Eigen::Vector3d::UnitZ(), -Eigen::Vector3d::UnitZ()};
};

void write_turned(const ScanFile& scan, const Eigen::Matrix4d& turned_from_scan,
                  const std::filesystem::path& file) {
  TriangleMesh mesh;
  Positions places;
  for (const Eigen::Vector3f& p : scan.points.positions) places.push_back(p.cast<double>() + scan.origin);
  mesh.positions = to_float(transform(turned_from_scan, places));
  mesh.triangles = scan.triangles;
  mesh.colours = scan.points.colours;
  std::ofstream out(file, std::ios::binary);
  write_ply(mesh, out);
}

/// Mean distance, mm of the unturned head, of the unturned clean cloud to a finished surface.
double measure_final_error(const FittedHead& unturned, const FittedHead& fitted,
                           const Eigen::Matrix4d& head_from_fitted, const GenericHead& head) {
  const std::vector<Eigen::Vector3f> surface =
      to_float(transform(head_from_fitted, evaluate_finest(fitted, head)));
  return mean_distance(unturned.cloud.positions,
                       SurfaceIndex(surface, head.hierarchy.triangles(head.hierarchy.level_count())));
}

}  // namespace

void measure_turned(const BenchWorld& world, const std::filesystem::path& store, const FitRun& everything) {
  const int turns = world.is_long ? kManyTurns : kFewTurns;
  Turner turner;
  int done = 0, tried = 0;
  double worst = 0;
  for (const BenchSubject& subject : world.data.subjects) {
    const auto found = everything.subjects.find(subject.name);
    if (found == everything.subjects.end() || !found->second.is_done) {
      tried += turns;
      continue;
    }
    const ScanFile scan = read_scan_file(subject.scan);
    const FittedHead unturned = load_fitted(store, found->second, world.head);
    const double mm_per_unit = 1 / std::cbrt(unturned.scan_from_head.topLeftCorner<3, 3>().determinant());
    const double own_error = measure_final_error(unturned, unturned, Eigen::Matrix4d::Identity(), world.head);
    for (int turn = 0; turn < turns; ++turn, ++tried) {
      const Eigen::Matrix4d turned_from_scan = turner.draw(mm_per_unit);
      const std::filesystem::path file = world.scratch / "turned.ply",
                                  turned_store = world.scratch / "turned";
      write_turned(scan, turned_from_scan, file);
      std::filesystem::remove_all(turned_store);
      const FitRun run = run_fit({file}, {turned_store, 0, {}, {}});
      const auto outcome = run.subjects.find("turned");
      if (outcome == run.subjects.end() || !outcome->second.is_done) {
        world.board.note(subject.name + " turned: " +
                         (outcome == run.subjects.end() ? run.program.err : outcome->second.error));
        continue;
      }
      ++done;
      const FittedHead fitted = load_fitted(turned_store, outcome->second, world.head);
      const Eigen::Matrix4d head_from_fitted =
          (turned_from_scan * unturned.scan_from_head).inverse() * fitted.scan_from_head;
      const double ratio = measure_final_error(unturned, fitted, head_from_fitted, world.head) / own_error;
      world.board.note(fmt::format("{} turned: {:.3f} x", subject.name, ratio));
      worst = std::max(worst, ratio);
    }
  }
  world.board.add(
      {fmt::format("turned, other units, moved: fitted ({} turns a scan, {} in all)", turns, tried),
       100.0 * done / std::max(1, tried), "%", at_least(100)});
  world.board.add(
      {"final error over the unturned, worst", done > 0 ? worst : std::nan(""), "x", at_most(1.15)});
}

}  // namespace phiz::bench
