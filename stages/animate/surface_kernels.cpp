#include "stages/animate/surface_kernels.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "stages/animate/lanes.h"
#include "stages/geometry/angle.h"
#include "stages/geometry/vector_clones.h"

namespace phiz {
namespace {

constexpr int kLanes = 8;
constexpr float kBlunt = -0.965f;  ///< cosine of 165 degrees: beyond it weigh_angle is no good

PHIZ_LANES_INLINE Float4 refine_regular(const Point4* points, const int* row) {
  const Float4 halves = load_at(points, row[0]) + load_at(points, row[1]);
  const Float4 eighths = load_at(points, row[2]) + load_at(points, row[3]);
  const Float4 sixteenths = (load_at(points, row[4]) + load_at(points, row[5])) +
                            (load_at(points, row[6]) + load_at(points, row[7]));
  return (halves * 0.5f + eighths * 0.125f) - sixteenths * 0.0625f;
}

PHIZ_LANES_INLINE Float4 refine_general(const Point4* points, const SurfacePlan::Level& plan, int row) {
  Float4 sum = {0, 0, 0, 0};
  for (int i = plan.general_offsets[row]; i < plan.general_offsets[row + 1]; ++i)
    sum += load_at(points, plan.general_points[i]) * plan.general_weights[i];
  return sum;
}

PHIZ_LANES_INLINE void refine_one(const SurfaceLevel& level, int row_idx) {
  const SurfacePlan::Level& plan = *level.plan;
  const int* row = plan.rows.data() + static_cast<std::ptrdiff_t>(row_idx) * SurfacePlan::kRowLength;
  store4(row[0] >= 0 ? refine_regular(level.points, row) : refine_general(level.points, plan, -1 - row[0]),
         level.raw[plan.first + row_idx]);
}

/// theta / sin(theta) from cos(theta), in place: a quotient of polynomials, equal ripples of 1e-4 for angles
/// up to 166 degrees; finite beyond (displace_blunt).
PHIZ_LANES_INLINE void weigh_angle(Float8& cosine) {
  const Float8 c = cosine, cc = c * c;
  const Float8 above =
      (c * 2.92305805f + 1.57070565f) + cc * ((c * 0.105513954f + 1.48308522f) + cc * -0.0154396184f);
  const Float8 below = (c * 2.49774585f + 1.0f) + cc * (c * 0.535799169f + 2.03376508f);
  cosine = above / below;
}

/// Eight rows of spokes one behind the other, as in a whole level.
struct RowsInOrder {
  const int* spokes;
  int width;
  __attribute__((always_inline)) int operator()(int k, int i) const { return spokes[k * width + i]; }
};

/// Eight rows anywhere.
struct RowsAnywhere {
  const int* spokes[kLanes];
  __attribute__((always_inline)) int operator()(int k, int i) const { return spokes[k][i]; }
};

/// Unit vectors to the i-th neighbours; 0 where the neighbour is the vertex itself.
template <class Rows>
PHIZ_LANES_INLINE void load_spokes(const Point4* points, const Vectors8& centres, const Rows& rows, int i,
                                   Vectors8& v) {
  const int offsets[kLanes] = {rows(0, i), rows(1, i), rows(2, i), rows(3, i),
                               rows(4, i), rows(5, i), rows(6, i), rows(7, i)};
  gather8(points, offsets, v);
  v.x -= centres.x;
  v.y -= centres.y;
  v.z -= centres.z;
  Float8 scale = v.x * v.x + v.y * v.y + v.z * v.z + 1e-30f;
  inverse_sqrt8(scale);
  v.x *= scale;
  v.y *= scale;
  v.z *= scale;
}

/// What is summed over a fan: area normals by angle, and the lowest cosine seen.
struct FanSum {
  Vectors8 normal;
  Float8 lowest;
};

PHIZ_LANES_INLINE void add_triangles(const Vectors8& from, const Vectors8& to, FanSum& sum) {
  Float8 weight = from.x * to.x + from.y * to.y + from.z * to.z;
  sum.lowest = weight < sum.lowest ? weight : sum.lowest;
  weigh_angle(weight);
  sum.normal.x += weight * (from.y * to.z - from.z * to.y);
  sum.normal.y += weight * (from.z * to.x - from.x * to.z);
  sum.normal.z += weight * (from.x * to.y - from.y * to.x);
}

/// A vertex with a triangle too blunt for weigh_angle, in double and with every angle exact. Compiled once,
/// so that it is the same whoever calls.
__attribute__((noinline)) void displace_blunt(const SurfaceLevel& level, int vertex) {
  const SurfacePlan::Level& plan = *level.plan;
  const int row = vertex - plan.first, width = plan.spokes_per_vertex;
  const int* spokes = plan.spokes.data() + static_cast<std::ptrdiff_t>(row) * width;
  const Point4& own = level.raw[vertex];
  const Eigen::Vector3d centre(own.x, own.y, own.z);
  const auto spoke = [&](int i) {
    const Float4 p = load_at(level.points, spokes[i % width]);
    return Eigen::Vector3d(Eigen::Vector3d(p[0], p[1], p[2]) - centre);
  };
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < width; ++i) {
    const Eigen::Vector3d from = spoke(i), to = spoke(i + 1), area = from.cross(to);
    const double length = area.norm();
    if (length > 0) sum += angle_of(length, from.dot(to)) / length * area;
  }
  const double length = sum.norm();
  const Eigen::Vector3d place =
      centre + double{level.displacements_mm[row]} / (length > 0 ? length : 1.0) * sum;
  level.points[vertex] = {static_cast<float>(place.x()), static_cast<float>(place.y()),
                          static_cast<float>(place.z()), 0};
}

PHIZ_LANES_INLINE bool is_any_below(const Float8& lanes, float limit) {
  bool is_below = false;
  for (int k = 0; k < kLanes; ++k) is_below |= lanes[k] < limit;
  return is_below;
}

/// Displaces the eight vertices `targets` (one may be named more than once); their fans are `rows`.
template <int kWidth, class Rows>
PHIZ_LANES_INLINE void displace_eight(const SurfaceLevel& level, const int* targets, const Float8& amounts,
                                      const Rows& rows) {
  const int width = kWidth > 0 ? kWidth : level.plan->spokes_per_vertex;
  int offsets[kLanes];
  for (int k = 0; k < kLanes; ++k) offsets[k] = targets[k] * SurfacePlan::kPointBytes;
  Vectors8 centres, first, from, to;
  FanSum fan;
  gather8(level.raw, offsets, centres);
  load_spokes(level.points, centres, rows, 0, first);
  from = first;
  fan.normal.x = fan.normal.y = fan.normal.z = fan.lowest = Float8{0, 0, 0, 0, 0, 0, 0, 0};
  for (int i = 1; i < width; ++i) {
    load_spokes(level.points, centres, rows, i, to);
    add_triangles(from, to, fan);
    from = to;
  }
  add_triangles(from, first, fan);
  const Vectors8& sum = fan.normal;
  Float8 length = sum.x * sum.x + sum.y * sum.y + sum.z * sum.z + 1e-30f;
  sqrt8(length);
  const Float8 scale = amounts / length;
  const Vectors8 result = {centres.x + scale * sum.x, centres.y + scale * sum.y, centres.z + scale * sum.z};
  scatter8(result, level.points, targets);
  if (!is_any_below(fan.lowest, kBlunt)) return;
  for (int k = 0; k < kLanes; ++k)
    if (fan.lowest[k] < kBlunt) displace_blunt(level, targets[k]);
}

/// vertex_of(i) names the i-th vertex. The last eight repeat the last one.
template <int kWidth, class VertexOf>
PHIZ_LANES_INLINE void displace_list(const SurfaceLevel& level, int begin, int end,
                                     const VertexOf& vertex_of) {
  const SurfacePlan::Level& plan = *level.plan;
  for (int i = begin; i < end; i += kLanes) {
    int targets[kLanes];
    Float8 amounts;
    RowsAnywhere rows;
    for (int k = 0; k < kLanes; ++k) {
      targets[k] = vertex_of(std::min(i + k, end - 1));
      const int row = targets[k] - plan.first;
      amounts[k] = level.displacements_mm[row];
      rows.spokes[k] = plan.spokes.data() + static_cast<std::ptrdiff_t>(row) * plan.spokes_per_vertex;
    }
    displace_eight<kWidth>(level, targets, amounts, rows);
  }
}

template <int kWidth>
PHIZ_LANES_INLINE void displace_level(const SurfaceLevel& level) {
  const SurfacePlan::Level& plan = *level.plan;
  const int whole = plan.count / kLanes * kLanes, width = kWidth > 0 ? kWidth : plan.spokes_per_vertex;
  for (int i = 0; i < whole; i += kLanes) {
    int targets[kLanes];
    for (int k = 0; k < kLanes; ++k) targets[k] = plan.first + i + k;
    Float8 amounts;
    std::memcpy(&amounts, level.displacements_mm + i, sizeof amounts);
    displace_eight<kWidth>(level, targets, amounts,
                           RowsInOrder{plan.spokes.data() + static_cast<std::ptrdiff_t>(i) * width, width});
  }
  displace_list<kWidth>(level, whole, plan.count, [&](int i) { return plan.first + i; });
}

}  // namespace

PHIZ_VECTOR_CLONES void refine_all(const SurfaceLevel& level) {
  for (int row = 0; row < level.plan->count; ++row) refine_one(level, row);
}

PHIZ_VECTOR_CLONES void refine_some(const SurfaceLevel& level, const int* vertices, int count) {
  for (int i = 0; i < count; ++i) refine_one(level, vertices[i] - level.plan->first);
}

PHIZ_VECTOR_CLONES void displace_all(const SurfaceLevel& level) {
  const int first = level.plan->first, count = level.plan->count;
  if (level.displacements_mm == nullptr)
    std::copy_n(level.raw + first, count, level.points + first);
  else if (level.plan->spokes_per_vertex == SurfacePlan::kSpokesAbove0)
    displace_level<SurfacePlan::kSpokesAbove0>(level);
  else
    displace_level<0>(level);
}

PHIZ_VECTOR_CLONES void displace_some(const SurfaceLevel& level, const int* vertices, int count) {
  const auto vertex_of = [&](int i) { return vertices[i]; };
  if (level.displacements_mm == nullptr) {
    for (int i = 0; i < count; ++i) level.points[vertices[i]] = level.raw[vertices[i]];
  } else if (level.plan->spokes_per_vertex == SurfacePlan::kSpokesAbove0) {
    displace_list<SurfacePlan::kSpokesAbove0>(level, 0, count, vertex_of);
  } else {
    displace_list<0>(level, 0, count, vertex_of);
  }
}

}  // namespace phiz
