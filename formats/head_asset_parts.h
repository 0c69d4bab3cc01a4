#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "formats/head_asset.h"
#include "formats/level_topology.h"

// What the writer and the readers of a head asset share.
namespace phiz::head_asset_parts {

constexpr std::size_t kMostVertices = std::size_t{1} << 25;  ///< of the finest level
constexpr double kLargestSteps = 1 << 23;                    ///< a float holds every whole number up to here

/// The rules that steps keep, written or read. Throws FormatError.
void check_steps(double displacement_step_mm, double position_step_mm);

/// CRC-32 (ISO 3309) of a stream.
std::uint32_t sum_of(std::string_view bytes);

/// The nearest whole number of steps. Throws FormatError, naming `what` and `idx`, beyond kLargestSteps.
std::int32_t to_steps(double value, double step, const char* what, std::size_t idx);
inline float from_steps(std::int32_t steps, double step) {
  return static_cast<float>(steps * step);
}

/// (u,v) in whole steps, coded as differences from what the triangles around foretell.
std::string encode_texture(const LevelTopology& control, const std::vector<Eigen::Vector3i>& triangles,
                           const std::vector<Eigen::Vector2i>& texture);
/// Throws FormatError.
std::vector<Eigen::Vector2i> decode_texture(const LevelTopology& control,
                                            const std::vector<Eigen::Vector3i>& triangles,
                                            std::string_view bytes, int steps);

}  // namespace phiz::head_asset_parts
