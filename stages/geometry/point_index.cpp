#include "stages/geometry/point_index.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>
#include <string>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

using Neighbour = PointIndex::Neighbour;

constexpr std::size_t kLeafSize = 12;

/// nanoflann bounds a subtree by a sum that it updates as it descends; rounding may push it above the true
/// distance. Results widen the bound that they report by more than that, so that no equal is ever cut off.
constexpr float kBoundSlack = 1.0f + 4e-5f;

bool nearer(const Neighbour& a, const Neighbour& b) {
  return a.squared_distance < b.squared_distance ||
         (a.squared_distance == b.squared_distance && a.point_idx < b.point_idx);
}

/// A point and its index at the caller, in the order of the tree's leaves: a leaf is one run of memory.
struct StoredPoint {
  float coordinates[3];
  int point_idx;
};

struct Cloud {
  std::vector<StoredPoint> points;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t idx, std::size_t dim) const { return points[idx].coordinates[dim]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Cloud>, Cloud, 3, int>;

class NearestOne {
 public:
  using DistanceType = float;
  NearestOne(const Cloud& cloud, float max_squared_distance) : cloud_(cloud) {
    best_.point_idx = std::numeric_limits<int>::max();
    best_.squared_distance = max_squared_distance;
  }
  bool addPoint(float squared_distance, int position) {
    const Neighbour candidate{cloud_.points[position].point_idx, squared_distance};
    if (nearer(candidate, best_)) best_ = candidate;
    return true;
  }
  float worstDist() const { return best_.squared_distance * kBoundSlack + std::numeric_limits<float>::min(); }
  bool full() const { return true; }
  Neighbour result() const {
    return best_.point_idx == std::numeric_limits<int>::max() ? Neighbour{} : best_;
  }

 private:
  const Cloud& cloud_;
  Neighbour best_;
};

class NearestSeveral {
 public:
  using DistanceType = float;
  NearestSeveral(const Cloud& cloud, std::size_t k, std::vector<Neighbour>& out)
      : cloud_(cloud), k_(k), out_(out) {}
  bool addPoint(float squared_distance, int position) {
    const Neighbour candidate{cloud_.points[position].point_idx, squared_distance};
    if (full() && !nearer(candidate, out_.back())) return true;
    if (full()) out_.pop_back();
    out_.insert(std::upper_bound(out_.begin(), out_.end(), candidate, nearer), candidate);
    return true;
  }
  float worstDist() const {
    if (!full()) return std::numeric_limits<float>::infinity();
    return out_.back().squared_distance * kBoundSlack + std::numeric_limits<float>::min();
  }
  bool full() const { return out_.size() >= k_; }

 private:
  const Cloud& cloud_;
  std::size_t k_;
  std::vector<Neighbour>& out_;
};

class AllWithin {
 public:
  using DistanceType = float;
  AllWithin(const Cloud& cloud, float squared_radius, std::vector<Neighbour>& out)
      : cloud_(cloud), squared_radius_(squared_radius), out_(out) {}
  bool addPoint(float squared_distance, int position) {
    if (squared_distance <= squared_radius_)
      out_.push_back({cloud_.points[position].point_idx, squared_distance});
    return true;
  }
  float worstDist() const { return squared_radius_ * kBoundSlack + std::numeric_limits<float>::min(); }
  bool full() const { return true; }

 private:
  const Cloud& cloud_;
  float squared_radius_;
  std::vector<Neighbour>& out_;
};

Cloud copy_points(std::span<const Eigen::Vector3f> points) {
  CONTRACT(points.size() < static_cast<std::size_t>(std::numeric_limits<int>::max()));
  Cloud cloud;
  cloud.points.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) throw InvalidInput("point " + std::to_string(i) + " is not finite");
    cloud.points.push_back({{points[i].x(), points[i].y(), points[i].z()}, static_cast<int>(i)});
  }
  return cloud;
}

}  // namespace

struct PointIndex::Impl {
  explicit Impl(std::span<const Eigen::Vector3f> points)
      : cloud(copy_points(points)), tree(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize)) {
    // The tree lists its points leaf by leaf: store them so, and let it refer to the new places.
    std::vector<StoredPoint> in_tree_order(cloud.points.size());
    for (std::size_t i = 0; i < tree.vAcc.size(); ++i) {
      in_tree_order[i] = cloud.points[tree.vAcc[i]];
      tree.vAcc[i] = static_cast<int>(i);
    }
    cloud.points = std::move(in_tree_order);
  }

  Cloud cloud;
  Tree tree;
};

PointIndex::PointIndex(std::span<const Eigen::Vector3f> points) : impl_(std::make_unique<Impl>(points)) {}
PointIndex::~PointIndex() = default;
PointIndex::PointIndex(PointIndex&&) noexcept = default;
PointIndex& PointIndex::operator=(PointIndex&&) noexcept = default;

void PointIndex::find_nearest(const Eigen::Vector3f& query, int k, std::vector<Neighbour>& out) const {
  CONTRACT(k >= 0);
  out.clear();
  if (k == 0 || !query.allFinite()) return;
  NearestSeveral result(impl_->cloud, static_cast<std::size_t>(k), out);
  impl_->tree.findNeighbors(result, query.data(), nanoflann::SearchParams());
}

Neighbour PointIndex::find_nearest(const Eigen::Vector3f& query, float max_distance) const {
  if (!(max_distance >= 0) || !query.allFinite()) return {};
  NearestOne result(impl_->cloud, max_distance * max_distance);
  impl_->tree.findNeighbors(result, query.data(), nanoflann::SearchParams());
  return result.result();
}

void PointIndex::find_within(const Eigen::Vector3f& query, float radius, std::vector<Neighbour>& out) const {
  out.clear();
  if (!(radius >= 0) || !query.allFinite()) return;
  AllWithin result(impl_->cloud, radius * radius, out);
  impl_->tree.findNeighbors(result, query.data(), nanoflann::SearchParams());
  std::sort(out.begin(), out.end(),
            [](const Neighbour& a, const Neighbour& b) { return a.point_idx < b.point_idx; });
}

}  // namespace phiz
