#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "stages/retarget/track.h"
#include "stages/synth/synth.h"
#include "tests/bench/fields.h"

namespace phiz::bench {
namespace {

constexpr int kFrames = 60, kScanPoints = 120'000;

const std::vector<std::string>& moved_controls() {
  static const std::vector<std::string> names = {
      "jawOpen",          "mouthSmileLeft", "mouthSmileRight",  "browInnerUp",         "browOuterUpLeft",
      "browOuterUpRight", "browDownLeft",   "browDownRight",    "mouthPucker",         "mouthFrownLeft",
      "mouthFrownRight",  "cheekPuff",      "mouthUpperUpLeft", "mouthLowerDownRight", "noseSneerLeft",
      "mouthStretchLeft", "mouthLeft",      "jawLeft"};
  return names;
}

std::vector<float> controls_at(const Deformation& rig, int frame) {
  std::vector<float> controls(rig.controls.size(), 0.0f);
  for (std::size_t k = 0; k < moved_controls().size(); ++k) {
    const double phase =
        2 * std::numbers::pi * frame / (22.0 + 3.0 * static_cast<double>(k)) + 1.3 * static_cast<double>(k);
    controls.at(static_cast<std::size_t>(find_control(rig, moved_controls()[k]))) =
        static_cast<float>(std::max(0.0, 0.55 * std::sin(phase)));
  }
  return controls;
}

Eigen::Isometry3d pose_at(int frame) {
  const double t = 2 * std::numbers::pi * frame / 60.0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = (Eigen::AngleAxisd(0.12 * std::sin(t), Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(0.07 * std::sin(2 * t), Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  pose.translation() = Eigen::Vector3d(5 * std::sin(t), 3 * std::sin(1.5 * t), 4 * (1 - std::cos(t)));
  return pose;
}

/// Scans of the posed head, made at a finer level than the tracker's.
class Sequence {
 public:
  Sequence(const FieldsWorld& world, const std::string& subject)
      : rig_(world.rig),
        maker_(world.bench.head.mesh, 3),
        neutral_(load_neutral(world, subject, maker_)),
        cascade_(rig_, sample_fields(rig_, neutral_.uv), neutral_) {
    target_.mesh.triangles = maker_.hierarchy().triangles(3);
    target_.materials.assign(neutral_.positions.size(), ScanMaterial::kSkin);
    mark(world, "scalp", ScanMaterial::kHair);
    mark(world, "eyes", ScanMaterial::kEye);
  }

  PointCloud scan(int frame) {
    target_.mesh.positions.resize(cascade_.point_count());
    cascade_.evaluate(parameters_of_controls(rig_, controls_at(rig_, frame)), target_.mesh.positions);
    const Eigen::Isometry3f pose = pose_at(frame).cast<float>();
    for (Eigen::Vector3f& p : target_.mesh.positions) p = pose * p;
    target_.mesh.normals.clear();
    target_.mesh.colours.assign(target_.mesh.positions.size(), {200, 180, 170});
    ScanOptions options;
    options.points = kScanPoints;
    return scan_surface(target_, options, static_cast<std::uint64_t>(frame) + 1);
  }

 private:
  void mark(const FieldsWorld& world, const std::string& region, ScanMaterial material) {
    const std::vector<bool> inside = world.bench.head.region_at(region, 3);
    for (std::size_t v = 0; v < inside.size(); ++v) {
      if (inside[v]) target_.materials[v] = material;
    }
  }

  const Deformation& rig_;
  NeutralMaker maker_;
  NeutralSurface neutral_;
  CompiledCascade cascade_;
  ScanTarget target_;
};

}  // namespace

void measure_track(const FieldsWorld& world) {
  const std::string subject = world.bench.data.subjects.front().name;
  Sequence sequence(world, subject);
  const NeutralMaker maker(world.bench.head.mesh, 2);
  Tracker tracker(world.rig, world.bench.head.mesh, maker, load_neutral(world, subject, maker));
  std::vector<double> moved, resting, turns_deg, shifts_mm, seconds;
  for (int frame = 0; frame < kFrames; ++frame) {
    const PointCloud cloud = sequence.scan(frame);
    const auto start = std::chrono::steady_clock::now();
    const TrackedFrame found = tracker.track(cloud.positions);
    seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    const std::vector<float> truth = controls_at(world.rig, frame);
    for (std::size_t c = 0; c < truth.size(); ++c) {
      const std::string& name = world.rig.controls[c].name;
      const bool is_moved = std::count(moved_controls().begin(), moved_controls().end(), name) > 0;
      (is_moved ? moved : resting).push_back(std::abs(found.controls[c] - truth[c]));
    }
    const Eigen::Isometry3d rest = pose_at(frame).inverse() * found.scan_from_head;
    turns_deg.push_back(Eigen::AngleAxisd(rest.rotation()).angle() * 180 / std::numbers::pi);
    shifts_mm.push_back(rest.translation().norm());
  }
  world.bench.board.note(
      fmt::format("{} frames of {} points made from {}, {} of the rig's {} controls move; all are solved for",
                  kFrames, kScanPoints, subject, moved_controls().size(), world.rig.controls.size()));
  world.bench.board.add({"track: controls that move, mean error", mean(moved), "", at_most(0.03)});
  world.bench.board.add({"track: controls that move, 95 %", quantile(moved, 0.95), "", {}});
  world.bench.board.add({"track: controls that rest, mean error", mean(resting), "", at_most(0.03)});
  world.bench.board.add({"track: pose, worst turn", quantile(turns_deg, 1), "deg", at_most(0.2)});
  world.bench.board.add({"track: pose, worst shift", quantile(shifts_mm, 1), "mm", at_most(0.2)});
  world.bench.board.add({"track: a frame", median(seconds), "s", {}});
}

}  // namespace phiz::bench
