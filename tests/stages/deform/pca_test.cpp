#include "stages/deform/pca.h"

#include <gtest/gtest.h>

#include <cmath>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

using Vectors = std::vector<std::vector<float>>;

std::vector<float> random_weights(std::size_t length) {
  std::vector<float> weights;
  for (std::size_t i = 0; i < length; ++i)
    weights.push_back(static_cast<float>(test::random().uniform(0.2, 2)));
  return weights;
}

/// Mean plus `directions` random directions of falling size.
Vectors random_shapes(int count, int directions, std::size_t length) {
  Vectors basis(directions + 1, std::vector<float>(length));
  for (auto& row : basis)
    for (float& value : row) value = static_cast<float>(test::random().normal());
  Vectors shapes;
  for (int s = 0; s < count; ++s) {
    std::vector<float> shape(length);
    for (std::size_t i = 0; i < length; ++i) shape[i] = 50 * basis[0][i];
    for (int d = 1; d <= directions; ++d) {
      const double amount = test::random().normal() * 10 / d;
      for (std::size_t i = 0; i < length; ++i) shape[i] += static_cast<float>(amount * basis[d][i]);
    }
    shapes.push_back(std::move(shape));
  }
  return shapes;
}

ShapeModel fit(const Vectors& shapes, const std::vector<float>& weights, int components) {
  StreamingPca pca(weights, components);
  for (const auto& shape : shapes) pca.add(shape);
  pca.finish();
  return make_shape_model(pca);
}

double largest_difference(const std::vector<float>& a, const std::vector<float>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(double{a[i]} - b[i]));
  return largest;
}

double inner(const ShapeModel& model, int a, int b) {
  double sum = 0;
  for (std::size_t i = 0; i < model.mean.size(); ++i)
    sum += double{model.weights[i]} * model.components[a][i] * model.components[b][i];
  return sum;
}

TEST(StreamingPca, ComponentsAreOrthonormalInTheWeights) {
  const Vectors shapes = random_shapes(40, 8, 300);
  const ShapeModel model = fit(shapes, random_weights(300), 20);
  ASSERT_EQ(model.components.size(), 8u);
  for (int a = 0; a < 8; ++a) {
    for (int b = 0; b <= a; ++b) EXPECT_NEAR(inner(model, a, b), a == b, 1e-5);
    if (a > 0) {
      EXPECT_LE(model.variances[a], model.variances[a - 1]);
    }
  }
}

TEST(StreamingPca, WhatItWasMadeOfIsReproducedExactly) {
  const Vectors shapes = random_shapes(35, 34, 500);  // several batches
  const ShapeModel model = fit(shapes, random_weights(500), 64);
  for (const auto& shape : shapes)
    EXPECT_LT(largest_difference(synthesise(model, project(model, shape)), shape), 2e-3);
}

TEST(StreamingPca, MeanAndVarianceAreThoseOfTheShapes) {
  const Vectors shapes = random_shapes(50, 5, 200);
  const std::vector<float> weights = random_weights(200);
  const ShapeModel model = fit(shapes, weights, 10);
  double scatter = 0;
  for (std::size_t i = 0; i < 200; ++i) {
    double mean = 0;
    for (const auto& shape : shapes) mean += shape[i] / 50.0;
    EXPECT_NEAR(model.mean[i], mean, 1e-3);
    for (const auto& shape : shapes) scatter += weights[i] * (shape[i] - mean) * (shape[i] - mean);
  }
  EXPECT_NEAR(model.total_variance / (scatter / 49), 1, 1e-5);
  double sum = 0;
  for (const double variance : model.variances) sum += variance;
  EXPECT_NEAR(sum / model.total_variance, 1, 1e-5);
}

TEST(StreamingPca, BatchesGiveWhatOneProblemGives) {
  const Vectors shapes = random_shapes(45, 6, 150);
  const std::vector<float> weights = random_weights(150);
  const ShapeModel model = fit(shapes, weights, 6);
  Vectors backwards(shapes.rbegin(), shapes.rend());
  const ShapeModel other = fit(backwards, weights, 6);
  for (int k = 0; k < 6; ++k) {
    EXPECT_NEAR(model.variances[k] / other.variances[k], 1, 1e-4);
    EXPECT_LT(largest_difference(model.components[k], other.components[k]), 1e-3);
  }
}

TEST(StreamingPca, SameBitsAtAnyThreadCount) {
  const Vectors shapes = random_shapes(20, 6, 40'000);
  const std::vector<float> weights(40'000, 1.0f);
  ShapeModel one, many;
  with_threads(1, [&] { one = fit(shapes, weights, 6); });
  with_threads(4, [&] { many = fit(shapes, weights, 6); });
  EXPECT_EQ(one.components, many.components);
  EXPECT_EQ(one.variances, many.variances);
}

TEST(StreamingPca, ErrorFallsWithEveryComponent) {
  const Vectors shapes = random_shapes(12, 30, 400);
  const std::vector<float> weights = random_weights(400);
  const ShapeModel model = fit(Vectors(shapes.begin() + 1, shapes.end()), weights, 20);
  double before = 1e300;
  const std::vector<double> all = project(model, shapes[0]);
  for (std::size_t k = 0; k <= all.size(); ++k) {
    const std::vector<float> got = synthesise(model, std::span(all).first(k));
    double error = 0;
    for (std::size_t i = 0; i < got.size(); ++i)
      error += weights[i] * std::pow(double{got[i]} - shapes[0][i], 2);
    EXPECT_LT(error, before);
    before = error;
  }
}

TEST(StreamingPca, HolesAreFilledFromWhatIsKnown) {
  const Vectors shapes = random_shapes(30, 4, 300);
  const ShapeModel model = fit(shapes, random_weights(300), 8);
  std::vector<bool> is_known(300, true);
  std::vector<float> broken = shapes[7];
  for (std::size_t i = 100; i < 200; ++i) {
    is_known[i] = false;
    broken[i] = 1e6f;
  }
  EXPECT_LT(largest_difference(synthesise(model, reconstruct(model, broken, is_known, 0)), shapes[7]), 1e-2);
  const std::vector<double> whole = reconstruct(model, shapes[7], std::vector<bool>(300, true), 0);
  const std::vector<double> projected = project(model, shapes[7]);
  for (std::size_t k = 0; k < whole.size(); ++k) EXPECT_NEAR(whole[k], projected[k], 1e-2);
  EXPECT_THROW(reconstruct(model, broken, std::vector<bool>(300, false), 0), InvalidInput);
}

TEST(StreamingPca, RefusesWhatDoesNotBelong) {
  EXPECT_THROW(StreamingPca({1, 1, 0}, 3), InvalidInput);
  EXPECT_THROW(StreamingPca({1, 1}, 0), InvalidInput);
  StreamingPca pca({1, 1, 1}, 3);
  EXPECT_THROW(pca.add(std::vector<float>{1, 2}), InvalidInput);
  EXPECT_THROW(pca.add(std::vector<float>{1, 2, std::nanf("")}), InvalidInput);
}

TEST(StreamingPca, OneShapeIsItsOwnMean) {
  const ShapeModel model = fit({{1, 2, 3}}, {1, 1, 1}, 3);
  EXPECT_EQ(model.components.size(), 0u);
  EXPECT_EQ(model.mean, (std::vector<float>{1, 2, 3}));
}

TEST(RigidAlignment, TakesARigidMotionOutExactly) {
  std::vector<Eigen::Vector3d> from, to;
  Eigen::Isometry3d motion(Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, -1).normalized()));
  motion.translation() = Eigen::Vector3d(4, -7, 9);
  for (int i = 0; i < 50; ++i) {
    from.emplace_back(test::random().normal() * 40, test::random().normal() * 60,
                      test::random().normal() * 50);
    to.push_back(motion * from.back());
  }
  const Eigen::Isometry3d found = find_rigid_alignment(from, to);
  EXPECT_LT((found.matrix() - motion.matrix()).norm(), 1e-12);
}

}  // namespace
}  // namespace phiz
