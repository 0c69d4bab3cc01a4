#include "stages/deform/cascade_kernels.h"

#include <cmath>
#include <cstring>

// Vectors of the compiler: the same operations on every lane in the same order, whatever the machine's
// registers hold, so that both paths below give the same bits (-ffp-contract=off).
namespace phiz {
namespace {

constexpr int kPoints = CompiledCascade::kBlockPoints, kFloats = 3 * kPoints;
constexpr int kLanes = 8, kVectors = kFloats / kLanes;

using Floats [[gnu::vector_size(32)]] = float;
using Ints [[gnu::vector_size(32)]] = std::int32_t;
using Shorts [[gnu::vector_size(16)]] = std::int16_t;

#define PHIZ_INLINE [[gnu::always_inline]] static inline

PHIZ_INLINE void load(Floats& to, const float* from) {
  std::memcpy(&to, from, sizeof(Floats));
}

PHIZ_INLINE void store(float* to, const Floats& from) {
  std::memcpy(to, &from, sizeof(Floats));
}

PHIZ_INLINE void widen(Floats& to, const std::int16_t* from) {
  Shorts packed;
  std::memcpy(&packed, from, sizeof(Shorts));
  to = __builtin_convertvector(__builtin_convertvector(packed, Ints), Floats);
}

/// buffer += sum of amounts times vectors.
PHIZ_INLINE void add_vectors(const CascadeRun& run, std::uint32_t begin, std::uint32_t end, float* buffer) {
  Floats sum[kVectors];
  for (int i = 0; i < kVectors; ++i) load(sum[i], buffer + kLanes * i);
  for (std::uint32_t k = begin; k < end; ++k) {
    const float amount = run.amounts[run.entries[k].step];
    if (amount == 0.0f) continue;
    const std::int16_t* vectors = run.data + run.entries[k].offset;
#pragma GCC unroll 6
    for (int i = 0; i < kVectors; ++i) {
      Floats value;
      widen(value, vectors + kLanes * i);
      sum[i] += amount * value;
    }
  }
  for (int i = 0; i < kVectors; ++i) store(buffer + kLanes * i, sum[i]);
}

/// Sum of amounts times masks of 16 points; false where none is active.
PHIZ_INLINE bool add_masks(const CascadeRun& run, std::uint32_t begin, std::uint32_t end, float* sums) {
  Floats low = {}, high = {};
  bool is_active = false;
  for (std::uint32_t k = begin; k < end; ++k) {
    const float amount = run.amounts[run.entries[k].step];
    if (amount == 0.0f) continue;
    Floats value;
    widen(value, run.data + run.entries[k].offset);
    low += amount * value;
    widen(value, run.data + run.entries[k].offset + kLanes);
    high += amount * value;
    is_active = true;
  }
  store(sums, low);
  store(sums + kLanes, high);
  return is_active;
}

/// sine and 1 - cosine, Taylor to the 17th power: within 1e-6 up to pi, the library's beyond.
PHIZ_INLINE void sine_and_rest(const float* angles, float* sine, float* rest) {
  Floats x;
  load(x, angles);
  const Floats t = x * x;
  const Floats s =
      x * (1.0f -
           t * (1.0f / 6 -
                t * (1.0f / 120 -
                     t * (1.0f / 5040 - t * (1.0f / 362880 - t * (1.0f / 39916800 - t * 1.6059044e-10f))))));
  const Floats r =
      t * (0.5f -
           t * (1.0f / 24 -
                t * (1.0f / 720 -
                     t * (1.0f / 40320 - t * (1.0f / 3628800 - t * (2.0876757e-9f - t * 1.1470746e-11f))))));
  store(sine, s);
  store(rest, r);
  for (int i = 0; i < kLanes; ++i) {
    if (std::fabs(angles[i]) <= 2.5f) continue;
    sine[i] = std::sin(angles[i]);
    rest[i] = 1.0f - std::cos(angles[i]);
  }
}

PHIZ_INLINE void rotate(const CompiledCascade::Operation& operation, const float* angles, float* buffer) {
  alignas(32) float x[kPoints], y[kPoints], z[kPoints], sine[kPoints], rest[kPoints];
  for (int i = 0; i < kPoints; ++i) x[i] = buffer[3 * i], y[i] = buffer[3 * i + 1], z[i] = buffer[3 * i + 2];
  for (int i = 0; i < kPoints; i += kLanes) sine_and_rest(angles + i, sine + i, rest + i);
  const Eigen::Vector3f &o = operation.axis_point, &k = operation.axis_direction;
  for (int i = 0; i < kPoints; i += kLanes) {
    Floats px, py, pz, s, r;
    load(px, x + i), load(py, y + i), load(pz, z + i), load(s, sine + i), load(r, rest + i);
    const Floats ax = px - o[0], ay = py - o[1], az = pz - o[2];
    const Floats along = k[0] * ax + k[1] * ay + k[2] * az;
    store(x + i, px + s * (k[1] * az - k[2] * ay) + r * (k[0] * along - ax));
    store(y + i, py + s * (k[2] * ax - k[0] * az) + r * (k[1] * along - ay));
    store(z + i, pz + s * (k[0] * ay - k[1] * ax) + r * (k[2] * along - az));
  }
  for (int i = 0; i < kPoints; ++i) buffer[3 * i] = x[i], buffer[3 * i + 1] = y[i], buffer[3 * i + 2] = z[i];
}

PHIZ_INLINE void blend(const float* shares, const float* other, float* buffer) {
  for (int i = 0; i < kFloats; ++i) buffer[i] += shares[i / 3] * (other[i] - buffer[i]);
}

PHIZ_INLINE void run_operation(const CascadeRun& run, std::size_t block, std::size_t index,
                               float (*slots)[kFloats]) {
  using Kind = CompiledCascade::Kind;
  const CompiledCascade::Operation& operation = run.operations[index];
  const std::uint32_t* offsets = run.entry_offsets + block * run.operations.size() + index;
  float* buffer = slots[operation.slot];
  alignas(32) float sums[kPoints];
  switch (operation.kind) {
    case Kind::kNeutral:
      std::memcpy(buffer, run.neutral + block * kFloats, sizeof(float) * kFloats);
      break;
    case Kind::kConstant:
      std::memcpy(buffer, run.constants[operation.constant] + block * kFloats, sizeof(float) * kFloats);
      break;
    case Kind::kCopy:
      std::memcpy(buffer, slots[operation.source], sizeof(float) * kFloats);
      break;
    case Kind::kLinear:
      if (offsets[0] != offsets[1]) add_vectors(run, offsets[0], offsets[1], buffer);
      break;
    case Kind::kRotate:
      if (offsets[0] != offsets[1] && add_masks(run, offsets[0], offsets[1], sums))
        rotate(operation, sums, buffer);
      break;
    case Kind::kBlend:
      if (offsets[0] != offsets[1] && add_masks(run, offsets[0], offsets[1], sums))
        blend(sums, slots[operation.source], buffer);
      break;
  }
}

PHIZ_INLINE void run_blocks(const CascadeRun& run) {
  alignas(64) float slots[CompiledCascade::kMostSlots][kFloats];
  for (std::size_t block = 0, first = 0; first < run.point_count; ++block, first += kPoints) {
    for (std::size_t i = 0; i < run.operations.size(); ++i) run_operation(run, block, i, slots);
    const float* result = slots[run.result_slot];
    const std::size_t count = run.point_count - first < kPoints ? run.point_count - first : kPoints;
    for (std::size_t i = 0; i < count; ++i)
      std::memcpy(run.positions[run.order[first + i]].data(), result + 3 * i, 3 * sizeof(float));
  }
}

}  // namespace

void run_cascade_plain(const CascadeRun& run) {
  run_blocks(run);
}

#if defined(__x86_64__) && defined(__GNUC__)
bool has_vector_path(VectorPath path) {
  return path != VectorPath::kAvx2 || __builtin_cpu_supports("avx2") != 0;
}

[[gnu::target("avx2")]] void run_cascade_avx2(const CascadeRun& run) {
  run_blocks(run);
}
#else
bool has_vector_path(VectorPath path) {
  return path != VectorPath::kAvx2;
}

void run_cascade_avx2(const CascadeRun& run) {
  run_blocks(run);
}
#endif

}  // namespace phiz
