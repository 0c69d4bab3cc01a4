#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "formats/point_cloud.h"

namespace phiz {

/// Keeps the rows of `cloud` for which keep[i] is set, in order. Returns how many went.
std::size_t keep_points(PointCloud& cloud, const std::vector<char>& keep);

/// 0 for points that stand alone: fewer than three others within `radius_mm`, or in a connected heap (cells
/// of that size) of less than a 500th of all points. O(N).
std::vector<char> find_supported(std::span<const Eigen::Vector3f> positions_mm, float radius_mm);

/// Median distance to the sixth neighbour over a sample of the cloud.
float median_spacing(std::span<const Eigen::Vector3f> positions);

}  // namespace phiz
