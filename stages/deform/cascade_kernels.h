#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "stages/deform/compiled_cascade.h"

namespace phiz {

/// One evaluation as the kernels see it.
struct CascadeRun {
  std::span<const CompiledCascade::Operation> operations;
  const std::uint32_t* entry_offsets = nullptr;
  const CompiledCascade::Entry* entries = nullptr;
  const std::int16_t* data = nullptr;
  const float* neutral = nullptr;
  const float* const* constants = nullptr;
  const float* amounts = nullptr;  ///< of each step, times one unit of its int16
  const int* order = nullptr;
  std::size_t point_count = 0;
  int result_slot = 0;
  Eigen::Vector3f* positions = nullptr;
};

void run_cascade_plain(const CascadeRun& run);
void run_cascade_avx2(const CascadeRun& run);  ///< only where has_vector_path says so

}  // namespace phiz
