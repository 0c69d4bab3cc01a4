#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace phiz {

/// Four boxes side by side, so that one pass of four-wide arithmetic tests them all. An absent child has an
/// empty box (lower > upper) that nothing reaches.
struct alignas(64) BoxNode {
  std::array<Eigen::Array4f, 3> lower, upper;  ///< [axis][child]
  /// >= 0: index of a node. < 0: a leaf with ~child = first << 3 | count, a run of `order`.
  std::array<int, 4> child;
};

/// Bounding volume hierarchy over boxes, four children a node, leaves of at most kLeafSize. Node 0 is the
/// root.
struct BoundingVolumes {
  static constexpr int kLeafSize = 4;
  static constexpr int kMaxDepth = 80;  ///< of any branch: a traversal needs a stack of 3 kMaxDepth + 1
  std::vector<BoxNode> nodes;
  std::vector<int> order;  ///< boxes in the order of the leaves
};

struct Box {
  Eigen::Array3f lower, upper;
};

/// Surface-area heuristic over 16 bins an axis (Wald 2007), built in parallel, then folded to four children a
/// node. The same tree at any thread count. Boxes must be finite; none gives no node. O(N log N).
BoundingVolumes build_bounding_volumes(std::span<const Box> boxes);

}  // namespace phiz
