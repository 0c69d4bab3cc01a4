#pragma once

#include "stages/animate/point4.h"
#include "stages/animate/surface_plan.h"

namespace phiz {

/// One level of a surface as the kernels see it. `points` and `raw` are the halves of one buffer.
struct SurfaceLevel {
  const SurfacePlan::Level* plan = nullptr;
  const float* displacements_mm = nullptr;  ///< of the level's own vertices; null: none
  Point4* points = nullptr;
  Point4* raw = nullptr;
};

/// Everything about a vertex is computed by the same operations in the same order whether its level is
/// evaluated whole or it alone: both give the same bits.

/// Undisplaced positions of the level's vertices (not for level 0, whose raw positions are given).
void refine_all(const SurfaceLevel& level);
void refine_some(const SurfaceLevel& level, const int* vertices, int count);

/// Final positions: raw + displacement along the angle-weighted normal of the raw surface.
void displace_all(const SurfaceLevel& level);
void displace_some(const SurfaceLevel& level, const int* vertices, int count);

}  // namespace phiz
