#include "stages/geometry/surface_index.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <utility>

#include "stages/geometry/bounding_volumes.h"
#include "stages/geometry/error.h"
#include "stages/geometry/morton.h"
#include "stages/geometry/parallel.h"
#include "stages/geometry/triangle_distance.h"

namespace phiz {
namespace {

constexpr std::size_t kQueryGrain = 1024;
constexpr std::size_t kStackSize = 3 * BoundingVolumes::kMaxDepth + 8;

/// Boxes are tested in float, distances to triangles in double: queries grow by this share of the
/// coordinates' size, and bounds by kBoundSlack, so that rounding never hides a triangle behind its box.
constexpr double kFloatSlack = 0x1p-21;
constexpr double kBoundSlack = 1.0 + 0x1p-20;

/// A triangle's corners, stored leaf by leaf.
struct StoredTriangle {
  Eigen::Vector3f a, b, c;
  int triangle_idx = -1;
};

/// A subtree to be visited: its squared distance in the upper half, its index in the lower. Distances are not
/// negative, so that the bits of floats are in the order of their values: one comparison orders both.
using Pending = std::uint64_t;

Pending pending(float squared_distance, int child) {
  return std::uint64_t{std::bit_cast<std::uint32_t>(squared_distance)} << 32 |
         static_cast<std::uint32_t>(child);
}
float distance_of(Pending item) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(item >> 32));
}
int child_of(Pending item) {
  return static_cast<int>(static_cast<std::uint32_t>(item));
}

struct Best {
  double squared_distance = std::numeric_limits<double>::infinity();
  int triangle_idx = std::numeric_limits<int>::max();
  int slot = -1;
};

float round_up(double value) {
  const double wider = value * kBoundSlack;
  return wider < std::numeric_limits<float>::max() ? static_cast<float>(wider)
                                                   : std::numeric_limits<float>::infinity();
}

/// The query as the box tests see it.
struct FloatQuery {
  FloatQuery(const Eigen::Vector3d& query, double largest_coordinate) {
    const double slack = kFloatSlack * std::max(largest_coordinate, query.cwiseAbs().maxCoeff());
    lower = (query.array() - slack).matrix().cast<float>();
    upper = (query.array() + slack).matrix().cast<float>();
  }
  Eigen::Vector3f lower, upper;
};

Eigen::Array4f squared_distances(const BoxNode& node, const FloatQuery& query) {
  Eigen::Array4f sum = Eigen::Array4f::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Array4f below = node.lower[axis] - query.upper[axis];
    const Eigen::Array4f above = query.lower[axis] - node.upper[axis];
    const Eigen::Array4f outside = below.max(above).max(0.0f);
    sum += outside * outside;
  }
  return sum;
}

/// A ray as the box tests see it: slabs grown by `slack`, directions never 0 so that no 0 * infinity arises.
struct SlabRay {
  SlabRay(const Eigen::Vector3d& from, const Eigen::Vector3d& direction, double largest_coordinate)
      : origin(from), slack(kFloatSlack * std::max(largest_coordinate, from.cwiseAbs().maxCoeff())) {
    for (int axis = 0; axis < 3; ++axis)
      inverse[axis] = std::abs(direction[axis]) > 1e-300 ? 1 / direction[axis] : 1e300;
  }
  /// Where the ray enters the box of a child; not a number if it misses it within [t_min, t_max].
  double enter(const BoxNode& node, int child, double t_min, double t_max) const {
    for (int axis = 0; axis < 3; ++axis) {
      const double t0 = (node.lower[axis][child] - slack - origin[axis]) * inverse[axis];
      const double t1 = (node.upper[axis][child] + slack - origin[axis]) * inverse[axis];
      t_min = std::max(t_min, std::min(t0, t1));
      t_max = std::min(t_max, std::max(t0, t1));
    }
    return t_min <= t_max ? t_min : std::numeric_limits<double>::quiet_NaN();
  }
  Eigen::Vector3d origin, inverse;
  double slack;
};

struct RayHit {
  double t = 0, v = 0, w = 0;
};

/// Two-sided. Edges are a little wider than they are, so that no ray slips between two triangles.
std::optional<RayHit> intersect(const StoredTriangle& triangle, const Eigen::Vector3d& origin,
                                const Eigen::Vector3d& direction) {
  constexpr double kEdge = 1e-9;
  const Eigen::Vector3d a = triangle.a.cast<double>();
  const Eigen::Vector3d ab = triangle.b.cast<double>() - a, ac = triangle.c.cast<double>() - a;
  const Eigen::Vector3d p = direction.cross(ac), from_a = origin - a;
  const double determinant = ab.dot(p);
  if (determinant == 0) return std::nullopt;
  const double v = from_a.dot(p) / determinant;
  if (!(v >= -kEdge && v <= 1 + kEdge)) return std::nullopt;
  const Eigen::Vector3d q = from_a.cross(ab);
  const double w = direction.dot(q) / determinant;
  if (!(w >= -kEdge && v + w <= 1 + kEdge)) return std::nullopt;
  return RayHit{ac.dot(q) / determinant, v, w};
}

}  // namespace

struct SurfaceIndex::Impl {
  BoundingVolumes volumes;
  std::vector<StoredTriangle> triangles;
  double largest_coordinate = 0;

  void consider(int slot, const Eigen::Vector3d& query, Best& best) const {
    const StoredTriangle& t = triangles[slot];
    const double squared =
        find_nearest_on_triangle(query, t.a.cast<double>(), t.b.cast<double>(), t.c.cast<double>())
            .squared_distance;
    if (squared < best.squared_distance ||
        (squared == best.squared_distance && t.triangle_idx < best.triangle_idx))
      best = {squared, t.triangle_idx, slot};
  }

  void find_nearest(const Eigen::Vector3d& query, Best& best) const;
  SurfaceHit hit(const Eigen::Vector3d& query, const Best& best) const;
};

namespace {

/// Pushes the reached children, farthest first, so that the nearest is on top. Returns how many.
int push_reached(const BoxNode& node, const Eigen::Array4f& distances, float bound, Pending* stack) {
  int count = 0;
  for (int i = 0; i < 4; ++i) {  // no branches: whether a child is reached cannot be foretold
    stack[count] = pending(distances[i], node.child[i]);
    count += distances[i] <= bound;
  }
  for (int i = 1; i < count; ++i) {
    const Pending item = stack[i];
    int place = i;
    for (; place > 0 && stack[place - 1] < item; --place) stack[place] = stack[place - 1];
    stack[place] = item;
  }
  return count;
}

}  // namespace

void SurfaceIndex::Impl::find_nearest(const Eigen::Vector3d& query, Best& best) const {
  if (volumes.nodes.empty()) return;
  const FloatQuery float_query(query, largest_coordinate);
  float bound = round_up(best.squared_distance);
  std::array<Pending, kStackSize> stack;
  int top = 0;
  stack[top++] = pending(0.0f, 0);
  while (top > 0) {
    const Pending next = stack[--top];
    if (!(distance_of(next) <= bound)) continue;
    const int child = child_of(next);
    if (child >= 0) {
      const BoxNode& node = volumes.nodes[child];
      top += push_reached(node, squared_distances(node, float_query), bound, stack.data() + top);
    } else {
      const int first = ~child >> 3, count = ~child & 7;
      for (int slot = first; slot < first + count; ++slot) consider(slot, query, best);
      bound = round_up(best.squared_distance);
    }
  }
}

SurfaceHit SurfaceIndex::Impl::hit(const Eigen::Vector3d& query, const Best& best) const {
  if (best.slot < 0) return {};
  const StoredTriangle& t = triangles[best.slot];
  const Eigen::Vector3d a = t.a.cast<double>(), b = t.b.cast<double>(), c = t.c.cast<double>();
  const TrianglePoint point = find_nearest_on_triangle(query, a, b, c);
  return {best.triangle_idx,
          {1 - point.v - point.w, point.v, point.w},
          a + (point.v * (b - a) + point.w * (c - a)),
          std::sqrt(point.squared_distance)};
}

SurfaceIndex::SurfaceIndex(std::span<const Eigen::Vector3f> positions,
                           std::span<const Eigen::Vector3i> triangles)
    : impl_(std::make_unique<Impl>()) {
  const int vertex_count = static_cast<int>(positions.size());
  std::vector<Box> boxes;
  boxes.reserve(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const Eigen::Vector3i& t = triangles[i];
    if (t.minCoeff() < 0 || t.maxCoeff() >= vertex_count)
      throw InvalidInput("triangle " + std::to_string(i) + " refers to a vertex that is not there");
    const Eigen::Array3f a = positions[t[0]], b = positions[t[1]], c = positions[t[2]];
    if (!(a + b + c).allFinite())
      throw InvalidInput("triangle " + std::to_string(i) + " has a corner that is not finite");
    boxes.push_back({a.min(b).min(c), a.max(b).max(c)});
    impl_->largest_coordinate = std::max(
        impl_->largest_coordinate, double{boxes.back().lower.abs().max(boxes.back().upper.abs()).maxCoeff()});
  }
  impl_->volumes = build_bounding_volumes(boxes);
  impl_->triangles.reserve(triangles.size());
  for (const int idx : impl_->volumes.order) {
    const Eigen::Vector3i& t = triangles[idx];
    impl_->triangles.push_back({positions[t[0]], positions[t[1]], positions[t[2]], idx});
  }
}

SurfaceIndex::~SurfaceIndex() = default;
SurfaceIndex::SurfaceIndex(SurfaceIndex&&) noexcept = default;
SurfaceIndex& SurfaceIndex::operator=(SurfaceIndex&&) noexcept = default;

std::optional<SurfaceHit> SurfaceIndex::find_nearest(const Eigen::Vector3d& query,
                                                     double max_distance) const {
  if (!query.allFinite() || !(max_distance >= 0)) return std::nullopt;
  Best best;
  best.squared_distance = max_distance * max_distance;
  impl_->find_nearest(query, best);
  if (best.slot < 0) return std::nullopt;
  return impl_->hit(query, best);
}

std::optional<SurfaceHit> SurfaceIndex::find_first_hit(const Eigen::Vector3d& origin,
                                                       const Eigen::Vector3d& direction, double t_min,
                                                       double t_max) const {
  if (!origin.allFinite() || !direction.allFinite() || impl_->volumes.nodes.empty()) return std::nullopt;
  const SlabRay ray(origin, direction, impl_->largest_coordinate);
  SurfaceHit best;
  best.triangle_idx = std::numeric_limits<int>::max();
  best.distance = t_max;
  std::array<std::pair<double, int>, kStackSize> stack;  // where the box is entered, child
  std::size_t top = 0;
  stack[top++] = {t_min, 0};
  while (top > 0) {
    const auto [entered, child] = stack[--top];
    if (!(entered <= best.distance)) continue;
    if (child >= 0) {
      const BoxNode& node = impl_->volumes.nodes[child];
      const std::size_t base = top;
      for (int i = 0; i < 4; ++i) {
        const double t = ray.enter(node, i, t_min, best.distance);
        if (t <= best.distance) stack[top++] = {t, node.child[i]};
      }
      std::sort(stack.begin() + base, stack.begin() + top, std::greater<>());
      continue;
    }
    const int first = ~child >> 3, count = ~child & 7;
    for (int slot = first; slot < first + count; ++slot) {
      const StoredTriangle& triangle = impl_->triangles[slot];
      const auto hit = intersect(triangle, origin, direction);
      if (!hit || !(hit->t > t_min) || !(hit->t <= best.distance)) continue;
      if (hit->t == best.distance && triangle.triangle_idx > best.triangle_idx) continue;
      best = {
          triangle.triangle_idx, {1 - hit->v - hit->w, hit->v, hit->w}, origin + hit->t * direction, hit->t};
    }
  }
  if (best.triangle_idx == std::numeric_limits<int>::max()) return std::nullopt;
  return best;
}

std::vector<SurfaceHit> SurfaceIndex::find_nearest(std::span<const Eigen::Vector3f> queries,
                                                   double max_distance) const {
  std::vector<SurfaceHit> hits(queries.size());
  if (!(max_distance >= 0)) return hits;
  const std::vector<int> order = morton_order(queries);
  parallel_for(order.size(), kQueryGrain, [&](std::size_t begin, std::size_t end) {
    int previous_slot = -1;
    for (std::size_t i = begin; i < end; ++i) {
      const Eigen::Vector3d query = queries[order[i]].cast<double>();
      if (!query.allFinite()) continue;
      Best best;
      best.squared_distance = max_distance * max_distance;
      // The neighbour's triangle is a good first bound; the answer does not depend on it.
      if (previous_slot >= 0) impl_->consider(previous_slot, query, best);
      impl_->find_nearest(query, best);
      if (best.slot >= 0) previous_slot = best.slot;
      hits[order[i]] = impl_->hit(query, best);
    }
  });
  return hits;
}

}  // namespace phiz
