#include "stages/align/align.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "tests/stages/synth/synth_samples.h"
#include "tests/support/random.h"

namespace phiz {
namespace {

const ControlMesh& generic_head() {
  static const ControlMesh head = test::read_generic_head();
  return head;
}

/// `count` points by area on the triangles of the generic head.
const std::vector<Eigen::Vector3d>& head_points() {
  static const std::vector<Eigen::Vector3d> points = [] {
    std::vector<Eigen::Vector3d> result;
    test::Random random(1);  // its own: the same points whichever test comes first
    const ControlMesh& head = generic_head();
    for (const auto& t : head.triangles) {
      const Eigen::Vector3d a = head.positions[t[0]], u = head.positions[t[1]] - a,
                            v = head.positions[t[2]] - a;
      const int n = 1 + static_cast<int>(u.cross(v).norm() / 2);  // four points on three square millimetres
      for (int i = 0; i < n; ++i) {
        double s = random.uniform(), r = random.uniform();
        if (s + r > 1) s = 1 - s, r = 1 - r;
        result.push_back(a + s * u + r * v);
      }
    }
    return result;
  }();
  return points;
}

PointCloud transformed(const Eigen::Affine3d& transform) {
  PointCloud cloud;
  for (const auto& p : head_points()) cloud.positions.push_back((transform * p).cast<float>());
  return cloud;
}

Eigen::Affine3d make_transform(double degrees, const Eigen::Vector3d& axis, const Eigen::Vector3d& scales,
                               const Eigen::Vector3d& shift) {
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  transform.linear() =
      Eigen::AngleAxisd(degrees * 0.017453292519943295, axis.normalized()).toRotationMatrix() *
      scales.asDiagonal();
  transform.translation() = shift;
  return transform;
}

/// Mean distance that the vertices of the generic head are off.
double misplacement(const AlignResult& result, const Eigen::Affine3d& truth) {
  double sum = 0;
  for (const auto& p : generic_head().positions)
    sum += ((result.head_from_model * p.homogeneous()).head<3>() - truth * p).norm();
  return sum / static_cast<double>(generic_head().positions.size());
}

double start_misplacement(const Eigen::Affine3d& truth, double head_scale) {
  double sum = 0;
  for (const auto& p : generic_head().positions) sum += (head_scale * p - truth * p).norm();
  return sum / static_cast<double>(generic_head().positions.size());
}

// Small pictures: these tests are about the search.
AlignOptions quick(double pose_weight = 0.0) {
  AlignOptions options;
  options.coarse_size = 128;
  options.fine_size = 256;
  options.max_evaluations = 600;
  options.pose_weight = pose_weight;
  return options;
}

TEST(Align, FindsAnAffineTransformedHead) {
  const Eigen::Affine3d truths[] = {
      make_transform(4, {1, 0.3, 0.2}, {1.04, 0.97, 1.02}, {3, -4, 2}),
      make_transform(-3, {0.2, 1, -0.5}, {0.95, 1.05, 1.0}, {-4, 2, 3}),
  };
  for (const Eigen::Affine3d& truth : truths) {
    const AlignResult result = align(transformed(truth), generic_head(), 1.0, quick());
    EXPECT_LT(result.white_pixels_after, result.white_pixels_before / 3);
    EXPECT_LT(misplacement(result, truth), 2.0);
    EXPECT_LT(misplacement(result, truth), 0.4 * start_misplacement(truth, 1.0));
    EXPECT_FALSE(result.clipped_back);
  }
}

TEST(Align, HeadScaleIsTheStart) {
  const Eigen::Affine3d truth = make_transform(0, {1, 0, 0}, {1.3, 1.3, 1.3}, {0, 0, 0});
  const AlignResult result = align(transformed(truth), generic_head(), 1.3, quick());
  EXPECT_LT(misplacement(result, truth), 1.5);
  EXPECT_LT((result.scales - Eigen::Vector3d::Constant(1.3)).cwiseAbs().maxCoeff(), 0.03);
}

TEST(Align, StaysWhereTheHeadAlreadyFits) {
  const Eigen::Affine3d truth = Eigen::Affine3d::Identity();
  const AlignResult result = align(transformed(truth), generic_head(), 1.0, quick(0.01));
  EXPECT_LE(result.white_pixels_after, result.white_pixels_before);
  EXPECT_LT(misplacement(result, truth), 1.0);
  EXPECT_LT(static_cast<double>(result.white_pixels_after), 0.03 * result.covered_pixels);
}

TEST(Align, ThePosePenaltyHoldsTheTurn) {
  const Eigen::Affine3d truth = make_transform(8, {1, 0, 0}, {1, 1, 1}, {0, 0, 0});
  const auto angle = [](const AlignResult& r) {
    const Eigen::Matrix3d linear =
        r.head_from_model.topLeftCorner<3, 3>() * r.scales.cwiseInverse().asDiagonal();
    return Eigen::AngleAxisd(linear).angle();
  };
  const PointCloud cloud = transformed(truth);
  EXPECT_LT(angle(align(cloud, generic_head(), 1.0, quick(0.2))),
            angle(align(cloud, generic_head(), 1.0, quick())));
}

TEST(Align, HalfAHeadIsComparedInFrontOnly) {
  const Eigen::Affine3d truth = make_transform(3, {0.5, 1, 0}, {1.03, 0.98, 1.0}, {3, -2, 2});
  const PointCloud whole = transformed(truth);
  PointCloud half;
  for (const auto& p : whole.positions)
    if (p.z() > -20) half.positions.push_back(p);
  const AlignResult result = align(half, generic_head(), 1.0, quick());
  EXPECT_TRUE(result.clipped_back);
  EXPECT_LT(misplacement(result, truth), 3.0);
  AlignOptions unclipped = quick();
  unclipped.clip_back = false;
  const AlignResult other = align(half, generic_head(), 1.0, unclipped);
  EXPECT_FALSE(other.clipped_back);
  EXPECT_LT(misplacement(result, truth), misplacement(other, truth));
}

TEST(Align, WhitePixelsAreThoseOfThePictures) {
  const AlignResult result =
      align(transformed(make_transform(2, {0, 1, 0}, {1, 1, 1}, {2, 0, 0})), generic_head(), 1.0, quick());
  std::int64_t covered = 0, white = 0;
  for (const ViewAxis axis : kViewAxes) {
    const auto& cloud = result.cloud_silhouettes[static_cast<int>(axis)];
    const auto& model = result.model_silhouettes[static_cast<int>(axis)];
    ASSERT_EQ(cloud.width(), 256);
    covered += count_pixels(cloud);
    const Plane& neck = generic_head().annotations.clipping_planes.at("neck");
    white += count_xor(cloud, model, make_half_plane_mask(neck.normal, neck.offset_mm, axis, result.frame));
  }
  EXPECT_EQ(result.covered_pixels, covered);
  EXPECT_EQ(result.white_pixels_after, white);
}

TEST(Align, SameBitsAtAnyThreadCount) {
  const PointCloud cloud = transformed(make_transform(4, {1, 1, 0}, {1.02, 1, 1}, {2, 1, 0}));
  AlignResult one, two;
  with_threads(1, [&] { one = align(cloud, generic_head(), 1.0, quick(0.01)); });
  with_threads(2, [&] { two = align(cloud, generic_head(), 1.0, quick(0.01)); });
  EXPECT_EQ(one.head_from_model, two.head_from_model);
  EXPECT_EQ(one.white_pixels_after, two.white_pixels_after);
}

TEST(Align, NamesAMissingClippingPlane) {
  ControlMesh head = generic_head();
  head.annotations.clipping_planes.erase("back");
  EXPECT_THROW(align(transformed(Eigen::Affine3d::Identity()), head, 1.0), InvalidInput);
  EXPECT_THROW(align(transformed(Eigen::Affine3d::Identity()), generic_head(), 0.0), ContractViolation);
}

}  // namespace
}  // namespace phiz
