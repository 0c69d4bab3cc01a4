#include "stages/retarget/track.h"

#include <gtest/gtest.h>

#include <fstream>
#include <numbers>

#include "formats/muscle_file.h"
#include "stages/deform/muscles.h"
#include "stages/geometry/error.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

const std::string kSamples = PHIZ_SOURCE_FOLDER "/samples/";

struct World {
  ControlMesh head;
  Deformation rig;
};

/// A small rig: jaw, smiles, brows.
const World& world() {
  static const World made = [] {
    World w;
    std::ifstream obj(kSamples + "generic_head/head.obj"), json(kSamples + "generic_head/head.json");
    w.head = read_control_mesh(obj, json);
    std::vector<MuscleFile> muscles;
    for (const char* name : {"jaw_open", "zygomatic_major", "frontalis_inner"}) {
      std::ifstream in(kSamples + "muscles/" + name + ".json");
      muscles.push_back(read_muscle_file(in));
    }
    RigFile rig;
    rig.controls = {{"jawOpen", {}, {{"jawOpen", 1}}},
                    {"mouthSmileLeft", {}, {{"zygomaticMajorLeft", 1}}},
                    {"mouthSmileRight", {}, {{"zygomaticMajorRight", 1}}},
                    {"browInnerUp", {}, {{"frontalisInnerLeft", 1}, {"frontalisInnerRight", 1}}}};
    w.rig = build_muscles(w.head, muscles, rig, {256});
    return w;
  }();
  return made;
}

/// Points scattered over the posed surface, with noise along its normals' length.
std::vector<Eigen::Vector3f> scatter(const std::vector<Eigen::Vector3f>& positions,
                                     const std::vector<Eigen::Vector3i>& triangles, int count,
                                     double noise_mm) {
  std::vector<Eigen::Vector3f> points;
  while (static_cast<int>(points.size()) < count) {
    const Eigen::Vector3i& corners = triangles[test::random().below(triangles.size())];
    const double a = test::random().uniform(), b = test::random().uniform() * (1 - a);
    Eigen::Vector3d p = a * positions[corners[0]].cast<double>() + b * positions[corners[1]].cast<double>() +
                        (1 - a - b) * positions[corners[2]].cast<double>();
    if (p.z() < 30) continue;  // seen from the front
    for (int c = 0; c < 3; ++c) p[c] += noise_mm * test::random().normal();
    points.push_back(p.cast<float>());
  }
  return points;
}

TEST(Tracker, FindsControlsAndPoseOfNoisyScans) {
  const NeutralMaker maker(world().head, 2);
  const NeutralSurface neutral = maker.make(world().head.positions, {});
  const CompiledCascade cascade(world().rig, sample_fields(world().rig, neutral.uv), neutral);
  Tracker tracker(world().rig, world().head, maker, neutral);
  for (int frame = 0; frame < 4; ++frame) {
    const std::vector<float> truth = {0.2f * static_cast<float>(frame),
                                      0.6f - 0.15f * static_cast<float>(frame), 0, 0.5f};
    std::vector<Eigen::Vector3f> positions(cascade.point_count());
    cascade.evaluate(parameters_of_controls(world().rig, truth), positions);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = Eigen::AngleAxisd(0.03 * frame, Eigen::Vector3d(1, 2, 0).normalized()).toRotationMatrix();
    pose.translation() = Eigen::Vector3d(frame, -frame, 0.5 * frame);
    std::vector<Eigen::Vector3f> points = scatter(positions, maker.hierarchy().triangles(2), 30'000, 0.15);
    for (Eigen::Vector3f& p : points) p = (pose * p.cast<double>()).cast<float>();
    for (int i = 0; i < 60; ++i)  // outliers
      points[i * 31] += Eigen::Vector3f(0, 0, static_cast<float>(test::random().uniform(5, 80)));
    const TrackedFrame found = tracker.track(points);
    for (std::size_t c = 0; c < truth.size(); ++c)
      EXPECT_NEAR(found.controls[c], truth[c], 0.03) << frame << " " << c;
    const Eigen::Isometry3d rest = pose.inverse() * found.scan_from_head;
    EXPECT_LT(Eigen::AngleAxisd(rest.rotation()).angle() * 180 / std::numbers::pi, 0.2);
    EXPECT_LT(rest.translation().norm(), 0.2);
  }
}

TEST(Tracker, RefusesScansThatAreSomewhereElse) {
  const NeutralMaker maker(world().head, 1);
  Tracker tracker(world().rig, world().head, maker, maker.make(world().head.positions, {}));
  EXPECT_THROW(tracker.track(std::vector<Eigen::Vector3f>(1000, Eigen::Vector3f(900, 0, 0))), InvalidInput);
  EXPECT_THROW(tracker.track({}), InvalidInput);
}

}  // namespace
}  // namespace phiz
