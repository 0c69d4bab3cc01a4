#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace phiz {

/// Indices of the points along a space-filling curve (Morton order, 10 bits an axis over their bounding box):
/// neighbours in the order are near each other. Points that are not finite come first; equal codes keep their
/// order. O(N): three passes of a radix sort.
std::vector<int> morton_order(std::span<const Eigen::Vector3f> points);

}  // namespace phiz
