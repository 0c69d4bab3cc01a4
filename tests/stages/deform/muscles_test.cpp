#include "stages/deform/muscles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <set>

#include "formats/motion.h"
#include "stages/deform/deform.h"
#include "stages/deform/muscle_shapes.h"
#include "stages/geometry/error.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

const std::string kSamples = PHIZ_SOURCE_FOLDER "/samples/";
constexpr int kSide = 128;  // coarser than the product's, for time

const ControlMesh& head() {
  static const ControlMesh mesh = [] {
    std::ifstream obj(kSamples + "generic_head/head.obj"), json(kSamples + "generic_head/head.json");
    return read_control_mesh(obj, json);
  }();
  return mesh;
}

const RigFile& rig_file() {
  static const RigFile rig = [] {
    std::ifstream in(kSamples + "muscles/rig.json");
    return read_rig_file(in);
  }();
  return rig;
}

MuscleFile muscle_file(const std::string& name) {
  std::ifstream in(kSamples + "muscles/" + name + ".json");
  return read_muscle_file(in);
}

const Deformation& rig() {
  static const Deformation made = [] {
    std::vector<MuscleFile> muscles;
    for (const std::string& name : rig_file().muscles) muscles.push_back(muscle_file(name));
    return build_muscles(head(), muscles, rig_file(), {kSide});
  }();
  return made;
}

const NeutralSurface& neutral() {
  static const NeutralSurface surface = NeutralMaker(head(), 1).make(head().positions, {});
  return surface;
}

std::vector<Eigen::Vector3d> ways(const std::string& control, float value = 1) {
  static const SampledFields fields = sample_fields(rig(), neutral().uv);
  static const CompiledCascade cascade(rig(), fields, neutral());
  std::vector<float> controls(rig().controls.size(), 0.0f);
  controls.at(static_cast<std::size_t>(find_control(rig(), control))) = value;
  std::vector<Eigen::Vector3f> positions(cascade.point_count());
  cascade.evaluate(parameters_of_controls(rig(), controls), positions);
  std::vector<Eigen::Vector3d> moved;
  for (std::size_t i = 0; i < positions.size(); ++i)
    moved.push_back((positions[i] - neutral().positions[i]).cast<double>());
  return moved;
}

TEST(Muscles, AnswerToEveryNameOfArkit) {
  std::set<std::string> names;
  for (const RigControl& control : rig().controls) names.insert(control.name);
  for (const std::string_view name : arkit_names()) EXPECT_TRUE(names.contains(std::string(name))) << name;
  EXPECT_GE(rig().fields.size(), 53u);
  EXPECT_EQ(find_control(rig(), "MouthSmileLeft"), find_control(rig(), "mouthSmile_L"));
  EXPECT_EQ(find_control(rig(), "mouth_L"), -1);
}

TEST(Muscles, EveryControlButTheTongueMovesTheFaceAndNotTheWholeHead) {
  for (const RigControl& control : rig().controls) {
    double largest = 0;
    std::size_t still = 0;
    const std::vector<Eigen::Vector3d> moved = ways(control.name);
    for (const Eigen::Vector3d& way : moved) {
      largest = std::max(largest, way.norm());
      still += way.norm() == 0;
    }
    if (control.name == "tongueOut") {
      EXPECT_EQ(largest, 0);
      continue;
    }
    EXPECT_GT(largest, 0.2) << control.name;
    EXPECT_LT(largest, 45) << control.name;
    EXPECT_GT(still, moved.size() / 3) << control.name;
  }
}

TEST(Muscles, SidesMoveAloneAndMirrorEachOther) {
  for (const std::string stem : {"mouthSmile", "browOuterUp", "mouthFrown", "cheekSquint", "eyeBlink"}) {
    const std::vector<Eigen::Vector3d> left = ways(stem + "Left"), right = ways(stem + "Right");
    double wrong_side = 0, sum_left = 0, sum_right = 0;
    for (std::size_t i = 0; i < left.size(); ++i) {
      const double u = neutral().uv[i].x();
      if (u < 0.5) wrong_side = std::max(wrong_side, left[i].norm());
      if (u > 0.5) wrong_side = std::max(wrong_side, right[i].norm());
      sum_left += left[i].norm();
      sum_right += right[i].norm();
    }
    EXPECT_LT(wrong_side, 0.2) << stem;
    EXPECT_NEAR(sum_left, sum_right, 0.03 * sum_left) << stem;
  }
}

TEST(Muscles, MagnitudesFallFromThePeakToZeroAtTheBorder) {
  for (int trial = 0; trial < 200; ++trial) {
    const double plateau = test::random().uniform(0, 0.9);
    double last = 1;
    for (double radius = 0; radius <= 1.2; radius += 0.01) {
      const double share = falloff(radius, plateau);
      EXPECT_LE(share, last);
      last = share;
    }
    EXPECT_EQ(falloff(0, plateau), 1);
    EXPECT_EQ(falloff(1, plateau), 0);
  }
  // A whole muscle of one pull, along rays from its peak over the generic head.
  MuscleFile muscle = muscle_file("risorius");
  muscle.masks.clear();
  const UvCanvas canvas = draw_uv_canvas(head(), kSide);
  const std::vector<Eigen::Vector3d> drawn = draw_muscle(head(), canvas, muscle);
  const Eigen::Vector3d centre = canvas.landmarks.at("mouth_left_corner"), radii = muscle.pulls[0].radii_mm;
  std::vector<std::pair<double, double>> by_radius;
  for (std::size_t i = 0; i < drawn.size(); ++i)
    by_radius.emplace_back((canvas.positions[i] - centre).cwiseQuotient(radii).norm(), drawn[i].norm());
  std::sort(by_radius.begin(), by_radius.end());
  for (std::size_t i = 1; i < by_radius.size(); ++i)
    EXPECT_LE(by_radius[i].second, by_radius[i - 1].second + 1e-9);
  EXPECT_GT(by_radius.front().second, 0.9 * muscle.pulls[0].amplitude_mm);
}

TEST(Muscles, TheJawKeepsTheChinInOneAndLetsTheUpperLipStand) {
  const std::vector<Eigen::Vector3d> open = ways("jawOpen");
  const auto way_at = [&](const char* landmark) {
    const Eigen::Vector3d place = neutral().landmarks.at(landmark);
    std::size_t best = 0;
    for (std::size_t i = 0; i < open.size(); ++i) {
      if ((neutral().positions[i].cast<double>() - place).norm() <
          (neutral().positions[best].cast<double>() - place).norm())
        best = i;
    }
    return open[best];
  };
  EXPECT_GT(way_at("mouth_outer_09").norm(), 15);
  EXPECT_LT(way_at("mouth_outer_09").y(), -10);
  EXPECT_LT(way_at("mouth_outer_03").norm(), 1);
  EXPECT_LT(way_at("nose_tip").norm(), 1e-3);
  // Rigid in the chin: two of its places keep their distance.
  const Eigen::Vector3d a = neutral().landmarks.at("jaw_07"), b = neutral().landmarks.at("jaw_09");
  EXPECT_NEAR(((a + way_at("jaw_07")) - (b + way_at("jaw_09"))).norm(), (a - b).norm(), 0.5);
}

TEST(Muscles, LidsMeet) {
  const std::vector<Eigen::Vector3d> blink = ways("eyeBlinkLeft");
  const auto place_after = [&](const char* landmark) {
    const SurfacePoint& point = head().annotations.landmarks.at(landmark);
    const UvCanvas canvas = draw_uv_canvas(head(), 64);
    Eigen::Vector2d uv = canvas.landmark_uv.at(landmark);
    Eigen::Vector3d way = Eigen::Vector3d::Zero();
    for (const DeformationField& field : rig().fields) {
      if (field.name == "orbicularisBlinkLeft") way = sample_field(field, kSide, kSide, uv).value;
    }
    return (position_at(point, head().triangles, head().positions) + way).eval();
  };
  for (const char* side : {"inner", "outer"}) {
    const std::string upper = std::string("eye_left_upper_") + side,
                      lower = std::string("eye_left_lower_") + side;
    const double open = (neutral().landmarks.at(upper) - neutral().landmarks.at(lower)).norm();
    EXPECT_LT(std::abs((place_after(upper.c_str()) - place_after(lower.c_str())).y()), 0.2 * open) << side;
  }
  EXPECT_FALSE(blink.empty());
}

TEST(Muscles, SayWhichMuscleNamesAPlaceThatIsNotThere) {
  MuscleFile muscle = muscle_file("risorius");
  muscle.pulls[0].centre = {{"elbow", 1}};
  RigFile none;
  try {
    build_muscles(head(), std::vector<MuscleFile>{muscle}, none, {32});
    FAIL() << "no refusal";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("risorius"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("elbow"), std::string::npos);
  }
}

}  // namespace
}  // namespace phiz
