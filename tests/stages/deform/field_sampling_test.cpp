#include <gtest/gtest.h>

#include "tests/stages/deform/deform_samples.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

constexpr int kSide = 17;

DeformationField random_field(FieldInterpolation interpolation) {
  std::vector<float> values;
  for (int i = 0; i < 3 * kSide * kSide; ++i) values.push_back(static_cast<float>(test::random().normal()));
  DeformationField field;
  field.image = crop_field_image(kSide, kSide, 3, values);
  field.interpolation = interpolation;
  return field;
}

Eigen::Vector2d random_uv() {
  return {test::random().uniform(), test::random().uniform()};
}

TEST(FieldSampling, PassesThroughTheNodes) {
  for (const FieldInterpolation interpolation :
       {FieldInterpolation::kBilinear, FieldInterpolation::kBicubic}) {
    const DeformationField field = random_field(interpolation);
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const Eigen::Vector2d uv(x / (kSide - 1.0), 1 - y / (kSide - 1.0));
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(sample_field(field, kSide, kSide, uv).value[c],
                      field.image.values[(y * kSide + x) * 3 + c], 1e-6);
      }
    }
  }
}

TEST(FieldSampling, SlopesAreThoseOfDifferences) {
  constexpr double kStep = 1e-6;
  for (const FieldInterpolation interpolation :
       {FieldInterpolation::kBilinear, FieldInterpolation::kBicubic}) {
    const DeformationField field = random_field(interpolation);
    for (int i = 0; i < 200; ++i) {
      // away from the lines of the grid, where bilinear slopes jump
      const auto inside = [](double x) {
        return (std::floor(16 * x) + 0.1 + 0.8 * (16 * x - std::floor(16 * x))) / 16;
      };
      const Eigen::Vector2d uv = random_uv().unaryExpr(inside);
      const FieldSample sample = sample_field(field, kSide, kSide, uv);
      const auto value = [&](double u, double v) {
        return sample_field(field, kSide, kSide, uv + Eigen::Vector2d(u, v)).value;
      };
      EXPECT_LT(((value(kStep, 0) - value(-kStep, 0)) / (2 * kStep) - sample.du).norm(), 1e-5);
      EXPECT_LT(((value(0, kStep) - value(0, -kStep)) / (2 * kStep) - sample.dv).norm(), 1e-5);
    }
  }
}

TEST(FieldSampling, BicubicIsSmoothAcrossTheGridAndBilinearContinuous) {
  const DeformationField smooth = random_field(FieldInterpolation::kBicubic);
  for (int i = 1; i + 1 < kSide; ++i) {
    const double u = i / (kSide - 1.0), v = test::random().uniform();
    const FieldSample left = sample_field(smooth, kSide, kSide, {u - 1e-9, v}),
                      right = sample_field(smooth, kSide, kSide, {u + 1e-9, v});
    EXPECT_LT((left.value - right.value).norm(), 1e-6);
    EXPECT_LT((left.du - right.du).norm(), 1e-4);
    DeformationField plain = smooth;
    plain.interpolation = FieldInterpolation::kBilinear;
    EXPECT_LT((sample_field(plain, kSide, kSide, {u - 1e-9, v}).value -
               sample_field(plain, kSide, kSide, {u + 1e-9, v}).value)
                  .norm(),
              1e-6);
  }
}

TEST(FieldSampling, AWindowActsAsTheWholeGrid) {
  DeformationField whole = random_field(FieldInterpolation::kBicubic);
  std::vector<float> values = whole.image.values;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      if (x >= 3 && x < 9 && y >= 5 && y < 12) continue;
      for (int c = 0; c < 3; ++c) values[(y * kSide + x) * 3 + c] = 0;
    }
  }
  whole.image.values = values;
  DeformationField cropped = whole;
  cropped.image = crop_field_image(kSide, kSide, 3, values);
  EXPECT_EQ(cropped.image.width, 6);
  EXPECT_EQ(cropped.image.height, 7);
  EXPECT_EQ(expand_field_image(cropped.image, kSide, kSide), values);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector2d uv = random_uv();
    EXPECT_EQ(sample_field(whole, kSide, kSide, uv).value, sample_field(cropped, kSide, kSide, uv).value);
  }
}

TEST(FieldSampling, ListsByFieldAndByPointAgree) {
  const Deformation deformation = test::make_sample_deformation();
  const NeutralSurface neutral = test::make_sample_surface(400);
  const SampledFields sampled = sample_fields(deformation, neutral.uv);
  for (int i = 0; i < 400; ++i) {
    std::vector<Eigen::Vector3d> values(deformation.fields.size(), Eigen::Vector3d::Zero());
    for (int k = sampled.offsets[i]; k < sampled.offsets[i + 1]; ++k) {
      const SampledFields::Field& field = sampled.fields[sampled.point_fields[k]];
      EXPECT_EQ(field.points[sampled.point_entries[k]], i);
      values[sampled.point_fields[k]] = field.values[sampled.point_entries[k]].cast<double>();
    }
    for (std::size_t f = 0; f < deformation.fields.size(); ++f)
      EXPECT_LT((sample_field(deformation.fields[f], 33, 33, neutral.uv[i]).value - values[f]).norm(), 1e-5);
  }
}

}  // namespace
}  // namespace phiz
