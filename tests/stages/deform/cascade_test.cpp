#include <gtest/gtest.h>

#include "formats/error.h"
#include "stages/geometry/error.h"
#include "tests/stages/deform/deform_samples.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

/// A smooth surface with slopes: what a subject would give.
SurfaceSample sheet(const Eigen::Vector2d& uv) {
  const double u = uv.x(), v = uv.y();
  SurfaceSample place;
  place.uv = uv;
  place.position = {180 * (u - 0.5), 200 * (v - 0.5), 40 * std::sin(3 * u) + 60 * v * v};
  place.du = {180, 0, 120 * std::cos(3 * u)};
  place.dv = {0, 200, 120 * v};
  const double angle = 0.4 * u + 0.7 * v;  // a turn about z
  place.frame << std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle), 0, 0, 0, 1;
  Eigen::Matrix3d slope;
  slope << -std::sin(angle), -std::cos(angle), 0, std::cos(angle), -std::sin(angle), 0, 0, 0, 0;
  place.frame_du = 0.4 * slope;
  place.frame_dv = 0.7 * slope;
  return place;
}

/// The sample fields as smooth functions, so that differences may be taken anywhere.
AnalyticFields smooth_fields(const Deformation& deformation) {
  AnalyticFields fields;
  double phase = 0;
  for (const DeformationField& field : deformation.fields) {
    if (field.image.empty()) continue;
    phase += 0.7;
    const Eigen::Vector3d amplitude(3, field.image.channels == 1 ? 0 : -2, field.image.channels == 1 ? 0 : 1);
    fields[field.name] = [phase, amplitude](const Eigen::Vector2d& uv) {
      const double a = 4 * uv.x() + 2 * uv.y() + phase;
      return FieldSample{0.3 * std::sin(a) * amplitude, 1.2 * std::cos(a) * amplitude,
                         0.6 * std::cos(a) * amplitude};
    };
  }
  return fields;
}

struct Fixture {
  Deformation deformation = test::make_sample_deformation();
  std::map<std::string, Eigen::Vector3d> landmarks = test::make_sample_surface(1).landmarks;
  Cascade cascade{deformation, landmarks, smooth_fields(deformation)};
};

TEST(Cascade, SlopesInParametersAreThoseOfDifferences) {
  const Fixture f;
  constexpr double kStep = 1e-5;
  for (int trial = 0; trial < 40; ++trial) {
    std::vector<double> q = test::draw_parameters(f.deformation);
    const SurfaceSample place = sheet({test::random().uniform(), test::random().uniform()});
    const CascadePoint point = f.cascade.differentiate(q, place);
    EXPECT_LT((point.position - f.cascade.evaluate(q, place)).norm(), 1e-12);
    for (std::size_t k = 0; k < q.size(); ++k) {
      std::vector<double> more = q, less = q;
      more[k] += kStep, less[k] -= kStep;
      const Eigen::Vector3d slope =
          (f.cascade.evaluate(more, place) - f.cascade.evaluate(less, place)) / (2 * kStep);
      EXPECT_LT((slope - point.dq.col(static_cast<int>(k))).norm(), 1e-5 * (1 + slope.norm()));
    }
  }
}

TEST(Cascade, SlopesInTheSquareAreThoseOfDifferences) {
  const Fixture f;
  constexpr double kStep = 1e-6;
  for (int trial = 0; trial < 40; ++trial) {
    const std::vector<double> q = test::draw_parameters(f.deformation);
    const Eigen::Vector2d uv(test::random().uniform(0.1, 0.9), test::random().uniform(0.1, 0.9));
    const CascadePoint point = f.cascade.differentiate(q, sheet(uv));
    const auto at = [&](double u, double v) {
      return f.cascade.evaluate(q, sheet(uv + Eigen::Vector2d(u, v)));
    };
    EXPECT_LT(((at(kStep, 0) - at(-kStep, 0)) / (2 * kStep) - point.du).norm(), 1e-4 * (1 + point.du.norm()));
    EXPECT_LT(((at(0, kStep) - at(0, -kStep)) / (2 * kStep) - point.dv).norm(), 1e-4 * (1 + point.dv.norm()));
  }
}

TEST(Cascade, RotationKeepsTheDistanceToTheAxis) {
  Deformation d = test::make_sample_deformation();
  d.output = "jaw";
  const auto landmarks = test::make_sample_surface(1).landmarks;
  const Cascade cascade(d, landmarks);
  const Eigen::Vector3d from = 0.5 * (landmarks.at("a") + landmarks.at("b")), to = landmarks.at("c");
  const Eigen::Vector3d axis = (to - from).normalized();
  std::vector<double> q = {0, 0, 1, 0, 0};
  for (int i = 0; i < 50; ++i) {
    const SurfaceSample place = sheet({test::random().uniform(), test::random().uniform()});
    const Eigen::Vector3d before = place.position - from, after = cascade.evaluate(q, place) - from;
    EXPECT_NEAR(before.dot(axis), after.dot(axis), 1e-9);
    EXPECT_NEAR(before.norm(), after.norm(), 1e-9);
  }
}

TEST(Cascade, ScaleFollowsTheSubjectsMeasure) {
  Deformation d = test::make_sample_deformation();
  d.output = "smile";
  auto landmarks = test::make_sample_surface(1).landmarks;
  const SurfaceSample place = sheet({0.4, 0.3});
  const std::vector<double> q = {1, 0, 0, 0, 0};
  const Eigen::Vector3d once = Cascade(d, landmarks).evaluate(q, place) - place.position;
  landmarks["c"] = landmarks["a"] + 2 * (landmarks["c"] - landmarks["a"]);
  const Eigen::Vector3d twice = Cascade(d, landmarks).evaluate(q, place) - place.position;
  EXPECT_LT((twice - 2 * once).norm(), 1e-9);
  EXPECT_GT(once.norm(), 1);
}

TEST(Cascade, NamesTheLandmarkThatIsMissing) {
  const Deformation d = test::make_sample_deformation();
  auto landmarks = test::make_sample_surface(1).landmarks;
  landmarks.erase("c");
  try {
    Cascade cascade(d, landmarks);
    FAIL() << "no refusal";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("'c'"), std::string::npos);
  }
}

TEST(Cascade, SampledPointsAreThoseOfTheSquare) {
  const Deformation d = test::make_sample_deformation();
  const NeutralSurface neutral = test::make_sample_surface(200);
  const SampledFields sampled = sample_fields(d, neutral.uv);
  const Cascade cascade(d, neutral.landmarks);
  const std::vector<double> q = test::draw_parameters(d);
  for (std::size_t i = 0; i < 200; ++i) {
    SurfaceSample place;
    place.uv = neutral.uv[i];
    place.position = neutral.positions[i].cast<double>();
    place.frame = neutral.frames[i].cast<double>();
    const CascadePoint a = cascade.differentiate(q, place), b = cascade.differentiate(q, sampled, neutral, i);
    EXPECT_LT((a.position - b.position).norm(), 1e-5);
    EXPECT_LT((a.dq - b.dq).norm(), 1e-4);
  }
}

TEST(Cascade, ControlsAddUpAndStayInRange) {
  const Deformation d = test::make_sample_deformation();
  const std::vector<float> q = parameters_of_controls(d, std::vector<float>{0.5f, 2.0f});
  EXPECT_EQ(q, (std::vector<float>{0.5f, 0.125f, 1.0f, 0.0f, 0.0f}));
}

}  // namespace
}  // namespace phiz
