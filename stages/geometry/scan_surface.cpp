#include "stages/geometry/scan_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

constexpr float kGridCellMm = 1.5f;
constexpr float kLeastNormalDot = 0.25f;
constexpr float kSoundConfidence = 0.6f;  ///< below it points count as rough
constexpr float kMostWidening = 5.0f;

/// First point of each sheet in each cell stands for it: a sheet is a set of points with normals within 60
/// degrees.
std::vector<int> choose_seeds(const PointCloud& cloud, const PointGrid& cells) {
  std::vector<int> seeds;
  for (std::size_t c = 0; c < cells.cell_count(); ++c) {
    const std::size_t first = seeds.size();
    for (int slot = cells.cell_begin(c); slot < cells.cell_end(c); ++slot) {
      const int i = cells.order()[slot];
      const bool known = std::any_of(seeds.begin() + first, seeds.end(),
                                     [&](int s) { return cloud.normals[s].dot(cloud.normals[i]) > 0.5f; });
      if (!known) seeds.push_back(i);
      if (seeds.size() - first == 3) break;
    }
  }
  return seeds;
}

}  // namespace

struct ScanSurface::Tree {
  const std::vector<Surfel>& surfels;
  using Index = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Tree>, Tree, 3, int>;
  std::unique_ptr<Index> index;

  explicit Tree(const std::vector<Surfel>& s) : surfels(s) {
    index = std::make_unique<Index>(3, *this, nanoflann::KDTreeSingleIndexAdaptorParams(8));
  }
  std::size_t kdtree_get_point_count() const { return surfels.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const { return surfels[i].position[axis]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

ScanSurface::ScanSurface(const PointCloud& cloud, float surfel_mm) : grid_(cloud.positions, kGridCellMm) {
  if (!cloud.has_normals() || !cloud.has_confidences())
    throw InvalidInput("the cloud has no normals or no confidence", "ingest it first");
  normals_.resize(cloud.size());
  confidences_.resize(cloud.size());
  for (std::size_t slot = 0; slot < cloud.size(); ++slot) {
    normals_[slot] = cloud.normals[grid_.order()[slot]];
    confidences_[slot] = cloud.confidences[grid_.order()[slot]];
  }
  const auto seeds = choose_seeds(cloud, PointGrid(cloud.positions, surfel_mm));
  surfels_.resize(seeds.size());
  parallel_for(seeds.size(), 512, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) {
      const Eigen::Vector3f p = cloud.positions[seeds[s]], n = cloud.normals[seeds[s]];
      Eigen::Vector3f mean = Eigen::Vector3f::Zero(), normal = Eigen::Vector3f::Zero();
      float confidence = 0, spread = 0;
      int count = 0;
      const float reach = 1.2f * surfel_mm;
      grid_.for_each_within(p, reach, [&](int slot, float d2) {
        if (normals_[slot].dot(n) < 0.5f) return;
        mean += grid_.sorted_points()[slot] - p;
        normal += normals_[slot];
        confidence += confidences_[slot];
        spread += d2;
        ++count;
      });
      mean /= float(count);
      normal.normalize();
      const Eigen::Vector3f tangential = mean - mean.dot(normal) * normal;
      const float radius = std::sqrt(std::max(spread / float(count), 1e-6f));
      surfels_[s] = {p + mean.dot(normal) * normal, normal, confidence / float(count),
                     count < 4 ? 1.0f : std::min(1.0f, tangential.norm() / (0.75f * radius))};
    }
  });
  tree_ = std::make_unique<Tree>(surfels_);
}

ScanSurface::~ScanSurface() = default;

ScanSurface::Match ScanSurface::find_match(const Eigen::Vector3f& position, const Eigen::Vector3f& normal,
                                           float normal_weight_mm, float max_distance) const {
  constexpr int kMost = 12;
  std::array<int, kMost> index;
  std::array<float, kMost> squared;
  const int found =
      static_cast<int>(tree_->index->knnSearch(position.data(), kMost, index.data(), squared.data()));
  Match best;
  float best_cost = std::numeric_limits<float>::max();
  for (int i = 0; i < found; ++i) {
    const Surfel& s = surfels_[index[i]];
    if (squared[i] > max_distance * max_distance || s.normal.dot(normal) < kLeastNormalDot) continue;
    const float cost = squared[i] + normal_weight_mm * normal_weight_mm * (s.normal - normal).squaredNorm();
    if (cost < best_cost || (cost == best_cost && index[i] < best.surfel_idx)) {
      best_cost = cost;
      best = {index[i], std::sqrt(squared[i])};
    }
  }
  return best;
}

ScanSurface::Measurement ScanSurface::measure(const Eigen::Vector3f& position, const Eigen::Vector3f& normal,
                                              float bandwidth_mm, float reach_mm) const {
  Measurement result;
  float offset = 0, bandwidth = bandwidth_mm;
  bool widened = false;
  for (int iteration = 0; iteration < 6; ++iteration) {
    const Eigen::Vector3f q = position + offset * normal;
    const float radius = 2.0f * bandwidth, inverse = 1.0f / (bandwidth * bandwidth);
    float weight_sum = 0, plane_sum = 0, confidence_sum = 0, plain_sum = 0;
    Eigen::Vector3f mean = Eigen::Vector3f::Zero(), mean_normal = Eigen::Vector3f::Zero();
    int count = 0;
    grid_.for_each_within(q, radius, [&](int slot, float d2) {
      const Eigen::Vector3f& m = normals_[slot];
      if (m.dot(normal) < kLeastNormalDot) return;
      const float taper = 1.0f - 0.25f * d2 * inverse;  // 1 - (d / radius)^2
      const float w = taper * taper * (0.05f + confidences_[slot]);
      const Eigen::Vector3f d = grid_.sorted_points()[slot] - q;
      weight_sum += w;
      plane_sum += w * m.dot(d);
      mean += w * d;
      mean_normal += w * m;
      confidence_sum += w * confidences_[slot];
      plain_sum += confidences_[slot];
      ++count;
    });
    if (count >= 6 && !widened) {  // hair: rough points are averaged over a wider neighbourhood
      widened = true;
      const float roughness = kSoundConfidence * count / std::max(plain_sum, 1e-3f);
      if (roughness > 1) {
        bandwidth = std::max(bandwidth, bandwidth_mm * std::min(roughness, kMostWidening));
        continue;
      }
    }
    if (count < 6) {  // too few: look farther
      if (bandwidth > 4.0f * bandwidth_mm || bandwidth > 0.7f * reach_mm + bandwidth_mm) return {};
      bandwidth *= 1.5f;
      continue;
    }
    const float along = mean_normal.dot(normal);
    const float length = mean_normal.norm();
    const float tangent_step = plane_sum / along;
    const float height_step = mean.dot(mean_normal) / (weight_sum * along);
    const Eigen::Vector3f centre = mean / weight_sum;
    const Eigen::Vector3f n = mean_normal / length;
    const float aside = (centre - centre.dot(n) * n).norm() / bandwidth;
    const float step = 0.5f * (tangent_step + height_step);
    offset += std::clamp(step, -1.5f * bandwidth, 1.5f * bandwidth);
    if (std::abs(offset) > reach_mm) return {};
    result.normal = n;
    result.offset_mm = offset;
    result.confidence =
        aside > 0.9f ? 0.0f : confidence_sum / weight_sum * std::min(1.0f, 2.0f * (1.0f - aside));
    if (std::abs(step) < 0.02f * bandwidth) break;
  }
  return result;
}

}  // namespace phiz
