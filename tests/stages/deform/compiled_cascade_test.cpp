#include "stages/deform/compiled_cascade.h"

#include <gtest/gtest.h>

#include <cstring>

#include "tests/stages/deform/deform_samples.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

struct Fixture {
  explicit Fixture(Deformation d = test::make_sample_deformation(), int count = 1003)
      : deformation(std::move(d)),
        neutral(test::make_sample_surface(count)),
        sampled(sample_fields(deformation, neutral.uv)),
        compiled(deformation, sampled, neutral) {}
  Deformation deformation;
  NeutralSurface neutral;
  SampledFields sampled;
  CompiledCascade compiled;

  std::vector<Eigen::Vector3f> evaluate(const std::vector<float>& q,
                                        VectorPath path = VectorPath::kBest) const {
    std::vector<Eigen::Vector3f> positions(neutral.positions.size());
    compiled.evaluate(q, positions, path);
    return positions;
  }
};

bool same_bits(const std::vector<Eigen::Vector3f>& a, const std::vector<Eigen::Vector3f>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0;
}

std::vector<float> floats(const std::vector<double>& q) {
  return {q.begin(), q.end()};
}

TEST(CompiledCascade, AgreesWithThePlainOneWithinItsBound) {
  const Fixture f;
  const Cascade plain(f.deformation, f.neutral.landmarks);
  for (int trial = 0; trial < 10; ++trial) {
    const std::vector<float> q = floats(test::draw_parameters(f.deformation));
    const std::vector<Eigen::Vector3f> positions = f.evaluate(q);
    const double bound = f.compiled.error_bound_mm(q);
    EXPECT_LT(bound, 0.01);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const std::vector<double> wide(q.begin(), q.end());
      const CascadePoint point = plain.differentiate(wide, f.sampled, f.neutral, i);
      EXPECT_LT((point.position - positions[i].cast<double>()).norm(), bound);
    }
  }
}

TEST(CompiledCascade, EveryVectorPathGivesTheSameBits) {
  if (!has_vector_path(VectorPath::kAvx2)) GTEST_SKIP() << "the machine has no AVX2";
  const Fixture f;
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<float> q = floats(test::draw_parameters(f.deformation));
    q[test::random().below(q.size())] = 0;
    if (trial == 0) q[2] = 9;  // angles beyond the polynomial's range
    EXPECT_TRUE(same_bits(f.evaluate(q, VectorPath::kPlain), f.evaluate(q, VectorPath::kAvx2)));
  }
}

TEST(CompiledCascade, NeutralParametersGiveTheNeutralSurfaceBitForBit) {
  Fixture f;
  EXPECT_TRUE(same_bits(f.evaluate({0, 0, 0, 0, 0}), f.neutral.positions));
  EXPECT_TRUE(same_bits(f.evaluate({0, 0, 0, 0, 0}, VectorPath::kPlain), f.neutral.positions));
}

TEST(CompiledCascade, PointsOutsideAFieldStayBitForBit) {
  const Fixture f;
  const std::vector<Eigen::Vector3f> positions = f.evaluate({0, 0.8f, 0, 0, 0});
  std::size_t still = 0;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if ((f.neutral.uv[i] - Eigen::Vector2d(0.6, 0.7)).norm() < 0.3) continue;
    ++still;
    EXPECT_EQ(positions[i], f.neutral.positions[i]);
  }
  EXPECT_GT(still, positions.size() / 3);
}

TEST(CompiledCascade, WorksForAnyNumberOfPoints) {
  for (const int count : {1, 2, 15, 16, 17, 31, 33}) {
    const Fixture f(test::make_sample_deformation(), count);
    EXPECT_TRUE(same_bits(f.evaluate({0, 0, 0, 0, 0}), f.neutral.positions)) << count;
    const std::vector<float> q = {1, 0.5f, 0.3f, 0.2f, 0.1f};
    EXPECT_TRUE(same_bits(f.evaluate(q, VectorPath::kPlain), f.evaluate(q))) << count;
  }
}

TEST(CompiledCascade, TouchesFewerBytesWhenLessIsActive) {
  const Fixture f;
  const std::size_t none = f.compiled.bytes_touched(std::vector<float>(5, 0.0f)),
                    one = f.compiled.bytes_touched(std::vector<float>{0, 1, 0, 0, 0}),
                    all = f.compiled.bytes_touched(std::vector<float>(5, 1.0f));
  EXPECT_LT(none, one);
  EXPECT_LT(one, all);
}

}  // namespace
}  // namespace phiz
