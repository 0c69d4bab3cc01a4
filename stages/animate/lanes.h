#pragma once

#include <cmath>
#include <cstring>

#include "stages/animate/point4.h"

namespace phiz {

/// Floats side by side, in the compiler's vector extension: the same operations on every lane in the same
/// order, whatever registers the machine has, so that the bits are the same everywhere.
typedef float Float4 __attribute__((vector_size(16)));
typedef float Float8 __attribute__((vector_size(32)));
typedef int Int8 __attribute__((vector_size(32)));

#define PHIZ_LANES_INLINE inline __attribute__((always_inline))

PHIZ_LANES_INLINE void store4(const Float4& lanes, Point4& point) {
  std::memcpy(&point.x, &lanes, sizeof lanes);
}

PHIZ_LANES_INLINE void sqrt8(Float8& a) {
  for (int k = 0; k < 8; ++k) a[k] = std::sqrt(a[k]);
}

/// a becomes 1 / sqrt(a) within 5e-6 of itself, a > 0: a guess from the exponent, two steps of Newton. The
/// machine's own estimates differ from maker to maker.
PHIZ_LANES_INLINE void inverse_sqrt8(Float8& a) {
  const Float8 half = a * 0.5f;
  Float8 r = (Float8)(0x5f375a86 - ((Int8)a >> 1));
  r = r * (1.5f - half * r * r);
  a = r * (1.5f - half * r * r);
}

/// Eight vectors, one a lane.
struct Vectors8 {
  Float8 x, y, z;
};

/// The point so many bytes behind `points`.
PHIZ_LANES_INLINE Float4 load_at(const Point4* points, int offset_bytes) {
  Float4 lanes;
  std::memcpy(&lanes, reinterpret_cast<const char*>(points) + offset_bytes, sizeof lanes);
  return lanes;
}

/// Eight points to lanes.
PHIZ_LANES_INLINE void gather8(const Point4* points, const int offsets_bytes[8], Vectors8& v) {
  const auto& at = offsets_bytes;
  const Float8 a =
      __builtin_shufflevector(load_at(points, at[0]), load_at(points, at[4]), 0, 1, 2, 3, 4, 5, 6, 7);
  const Float8 b =
      __builtin_shufflevector(load_at(points, at[1]), load_at(points, at[5]), 0, 1, 2, 3, 4, 5, 6, 7);
  const Float8 c =
      __builtin_shufflevector(load_at(points, at[2]), load_at(points, at[6]), 0, 1, 2, 3, 4, 5, 6, 7);
  const Float8 d =
      __builtin_shufflevector(load_at(points, at[3]), load_at(points, at[7]), 0, 1, 2, 3, 4, 5, 6, 7);
  const Float8 low_ab = __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
  const Float8 low_cd = __builtin_shufflevector(c, d, 0, 8, 1, 9, 4, 12, 5, 13);
  const Float8 high_ab = __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
  const Float8 high_cd = __builtin_shufflevector(c, d, 2, 10, 3, 11, 6, 14, 7, 15);
  v.x = __builtin_shufflevector(low_ab, low_cd, 0, 1, 8, 9, 4, 5, 12, 13);
  v.y = __builtin_shufflevector(low_ab, low_cd, 2, 3, 10, 11, 6, 7, 14, 15);
  v.z = __builtin_shufflevector(high_ab, high_cd, 0, 1, 8, 9, 4, 5, 12, 13);
}

PHIZ_LANES_INLINE void store_pair(const Float8& lanes, Point4& low, Point4& high) {
  store4(__builtin_shufflevector(lanes, lanes, 0, 1, 2, 3), low);
  store4(__builtin_shufflevector(lanes, lanes, 4, 5, 6, 7), high);
}

/// Lanes to points; the fourth numbers become 0.
PHIZ_LANES_INLINE void scatter8(const Vectors8& v, Point4* points, const int targets[8]) {
  const Float8 zero = {0, 0, 0, 0, 0, 0, 0, 0};
  const Float8 low_xy = __builtin_shufflevector(v.x, v.y, 0, 8, 1, 9, 4, 12, 5, 13);
  const Float8 high_xy = __builtin_shufflevector(v.x, v.y, 2, 10, 3, 11, 6, 14, 7, 15);
  const Float8 low_z = __builtin_shufflevector(v.z, zero, 0, 8, 1, 9, 4, 12, 5, 13);
  const Float8 high_z = __builtin_shufflevector(v.z, zero, 2, 10, 3, 11, 6, 14, 7, 15);
  store_pair(__builtin_shufflevector(low_xy, low_z, 0, 1, 8, 9, 4, 5, 12, 13), points[targets[0]],
             points[targets[4]]);
  store_pair(__builtin_shufflevector(low_xy, low_z, 2, 3, 10, 11, 6, 7, 14, 15), points[targets[1]],
             points[targets[5]]);
  store_pair(__builtin_shufflevector(high_xy, high_z, 0, 1, 8, 9, 4, 5, 12, 13), points[targets[2]],
             points[targets[6]]);
  store_pair(__builtin_shufflevector(high_xy, high_z, 2, 3, 10, 11, 6, 7, 14, 15), points[targets[3]],
             points[targets[7]]);
}

}  // namespace phiz
