#include "stages/fit/eyelids.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "tests/stages/fit/fit_samples.h"

namespace phiz {
namespace {

using test::generic_head;
using test::generic_hierarchy;
using Positions = Eyelids::Positions;

Positions open_head() {
  Positions x(generic_head().positions.size(), 3);
  for (Eigen::Index i = 0; i < x.rows(); ++i) x.row(i) = generic_head().positions[i].transpose();
  return x;
}

Positions shut_head() {
  const Eyelids lids(generic_head());
  Positions x = open_head();
  for (int eye = 0; eye < lids.eye_count(); ++eye) lids.shut(eye, x);
  return x;
}

ControlPositions to_control(const Positions& x) {
  ControlPositions positions(x.rows());
  for (Eigen::Index i = 0; i < x.rows(); ++i) positions[i] = x.row(i).transpose();
  return positions;
}

/// Points of level 2 that can be seen from the front: no point of the surface is more than 0.5 mm before
/// them.
PointCloud scan_from_the_front(const Positions& x) {
  const PointCloud all = test::sample_surface(to_control(x), 150'000);
  constexpr float kPixelMm = 0.5f;
  std::map<std::pair<int, int>, float> depth;
  const auto pixel = [&](const Eigen::Vector3f& p) {
    return std::pair(int(std::floor(p.x() / kPixelMm)), int(std::floor(p.y() / kPixelMm)));
  };
  for (const auto& p : all.positions) {
    const auto [at, is_new] = depth.try_emplace(pixel(p), p.z());
    if (!is_new) at->second = std::max(at->second, p.z());
  }
  PointCloud cloud;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Eigen::Vector3f& p = all.positions[i];
    const bool face = p.z() > 40 && std::abs(p.x()) < 65;
    if (face && (all.normals[i].z() < 0.05f || depth[pixel(p)] > p.z() + 0.5f)) continue;
    cloud.positions.push_back(p);
    cloud.normals.push_back(all.normals[i]);
    cloud.confidences.push_back(1);
  }
  return cloud;
}

TEST(Eyelids, AHeadHasTwoEyesAndWhatIsNotTheirsStays) {
  const Eyelids lids(generic_head());
  ASSERT_EQ(lids.eye_count(), 2);
  const Positions before = open_head();
  for (const int eye : {0, 1}) {
    Positions x = before;
    lids.shut(eye, x);
    const std::vector<int>& moved = lids.moved(eye);
    ASSERT_TRUE(std::is_sorted(moved.begin(), moved.end()));
    for (Eigen::Index v = 0; v < x.rows(); ++v) {
      if (!std::binary_search(moved.begin(), moved.end(), static_cast<int>(v))) {
        ASSERT_EQ(x.row(v), before.row(v)) << v;
      }
    }
    EXPECT_GT((x - before).cwiseAbs().maxCoeff(), 4);
  }
}

TEST(Eyelids, BothEyesShutAlike) {
  const Positions x = shut_head();
  const std::vector<int>& mirror = generic_head().annotations.mirror;
  ASSERT_EQ(static_cast<Eigen::Index>(mirror.size()), x.rows());
  for (Eigen::Index v = 0; v < x.rows(); ++v) {
    const Eigen::RowVector3d other = x.row(mirror[v]).cwiseProduct(Eigen::RowVector3d(-1, 1, 1));
    ASSERT_LT((x.row(v) - other).norm(), 0.3) << v;
  }
}

TEST(Eyelids, NothingOfTheEyeIsSeenBehindShutLids) {
  const Eyelids lids(generic_head());
  const ControlPositions shut = to_control(shut_head());
  const auto surface = evaluate_surface(generic_hierarchy(), shut, {}, 2);
  for (int eye = 0; eye < lids.eye_count(); ++eye) {
    const std::vector<int>& inside = lids.inside(eye);
    double eye_low = 1e9, eye_high = -1e9, front = -1e9, eye_front = -1e9;
    for (const int v : inside) {
      eye_low = std::min(eye_low, shut[v].y()), eye_high = std::max(eye_high, shut[v].y());
      eye_front = std::max(eye_front, shut[v].z());
    }
    EXPECT_LT(eye_high - eye_low, 5);  // open: 12
    for (const int v : lids.moved(eye)) front = std::max(front, shut[v].z());
    EXPECT_GT(front, eye_front + 1);
  }
}

TEST(Eyelids, AFitTellsShutEyesFromOpenOnes) {
  GlobalFitOptions options;
  const ControlPositions& start = generic_head().positions;
  for (const bool shut : {false, true}) {
    const Positions truth = shut ? shut_head() : open_head();
    const ScanSurface scan(scan_from_the_front(truth));
    const GlobalFitResult fitted = fit_global(scan, generic_head(), generic_hierarchy(), start, options);
    EXPECT_EQ(fitted.eyes_shut, shut);
    options.eyes = shut ? Eyes::kOpen : Eyes::kShut;  // who knows better is believed
    EXPECT_EQ(fit_global(scan, generic_head(), generic_hierarchy(), start, options).eyes_shut, !shut);
    options.eyes = Eyes::kAsTheScan;
  }
}

TEST(Eyelids, AFitGoesOnFromEveryStateWithShutEyesToTheSameBits) {
  const ScanSurface scan(scan_from_the_front(shut_head()));
  GlobalFitOptions options;
  options.rounds = 2;
  options.soft_rounds = 1;
  options.iterations_per_round = 2;
  options.eyes = Eyes::kShut;
  std::vector<GlobalFitState> states;
  const auto fit = [&](const GlobalFitState* from, const GlobalFitProgress& progress) {
    return fit_global(scan, generic_head(), generic_hierarchy(), generic_head().positions, options, from,
                      progress);
  };
  const GlobalFitResult whole = fit(nullptr, [&](const GlobalFitState& state) {
    states.push_back(state);
    return true;
  });
  EXPECT_TRUE(whole.eyes_shut);
  for (const GlobalFitState& state : states) {
    const GlobalFitResult resumed = fit(&state, {});
    EXPECT_EQ(resumed.positions, whole.positions) << state.round << ' ' << state.iteration;
    EXPECT_TRUE(resumed.eyes_shut);
  }
}

}  // namespace
}  // namespace phiz
