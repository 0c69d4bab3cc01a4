#include "stages/geometry/bounding_volumes.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

constexpr int kMaxBins = 16, kMinBins = 4;
constexpr int kParallelFrom = 4096;
constexpr int kHalvesFromDepth = BoundingVolumes::kMaxDepth - 28;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Boxes in four floats a corner (the last is 0), so that they grow in two vector instructions.
struct WideBox {
  Eigen::Array4f lower = {kInfinity, kInfinity, kInfinity, 0.0f};
  Eigen::Array4f upper = {-kInfinity, -kInfinity, -kInfinity, 0.0f};
};

void extend(WideBox& box, const WideBox& other) {
  box.lower = box.lower.min(other.lower);
  box.upper = box.upper.max(other.upper);
}

float half_area(const WideBox& box) {
  const Eigen::Array4f size = (box.upper - box.lower).max(0.0f);
  return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
}

/// Boxes travel with their indices while they are sorted, so that every pass reads memory in order.
struct Item {
  WideBox box;
  int idx = 0;
};

/// A run of items and the box round it; `node` names its binary node, -1 for a leaf.
struct Subtree {
  int begin = 0, end = 0;
  int node = -1;
  WideBox box;
  int size() const { return end - begin; }
};

struct Bin {
  WideBox box;
  int count = 0;
};

struct Split {
  float cost = kInfinity;
  int axis = -1;
  int bin = 0;  ///< items of bins below it go left
};

class Binning {
 public:
  /// Small runs are sorted into fewer bins: most of the tree is small runs.
  Binning(const WideBox& centres, int item_count)
      : count_(std::clamp(item_count / 4, kMinBins, kMaxBins)), lower_(centres.lower) {
    const Eigen::Array4f size = centres.upper - centres.lower;
    for (int axis = 0; axis < 3; ++axis) {
      scale_[axis] = size[axis] > 0 ? static_cast<float>(count_) / size[axis] : 0.0f;
      if (!(scale_[axis] < kInfinity)) scale_[axis] = 0.0f;
    }
  }
  int count() const { return count_; }
  bool splits(int axis) const { return scale_[axis] > 0; }
  Eigen::Array4i bins_of(const WideBox& box) const {
    return ((box.lower + box.upper - lower_) * scale_).cast<int>().min(count_ - 1);
  }

 private:
  int count_;
  Eigen::Array4f lower_, scale_ = Eigen::Array4f::Zero();
};

using Bins = std::vector<Bin>;  ///< those of the first axis, of the second, of the third

Bins fill_bins(std::span<const Item> items, const Binning& binning) {
  Bins bins(3 * static_cast<std::size_t>(binning.count()));
  for (const Item& item : items) {
    const Eigen::Array4i places = binning.bins_of(item.box);
    for (int axis = 0; axis < 3; ++axis) {
      Bin& bin = bins[axis * binning.count() + places[axis]];
      extend(bin.box, item.box);
      ++bin.count;
    }
  }
  return bins;
}

Split find_split(const Bins& bins, const Binning& binning) {
  Split best;
  for (int axis = 0; axis < 3; ++axis) {
    if (!binning.splits(axis)) continue;
    const Bin* axis_bins = bins.data() + axis * binning.count();
    std::array<float, kMaxBins> right_costs;
    Bin right;
    for (int b = binning.count() - 1; b > 0; --b) {
      extend(right.box, axis_bins[b].box);
      right.count += axis_bins[b].count;
      right_costs[b] = right.count ? half_area(right.box) * static_cast<float>(right.count) : kInfinity;
    }
    Bin left;
    for (int b = 1; b < binning.count(); ++b) {
      extend(left.box, axis_bins[b - 1].box);
      left.count += axis_bins[b - 1].count;
      if (left.count == 0) continue;
      const float cost = half_area(left.box) * static_cast<float>(left.count) + right_costs[b];
      if (cost < best.cost) best = {cost, axis, b};
    }
  }
  return best;
}

class Builder {
 public:
  explicit Builder(std::span<const Box> boxes) : items_(boxes.size()), halves_(boxes.size()) {
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      items_[i].box.lower.head<3>() = boxes[i].lower;
      items_[i].box.upper.head<3>() = boxes[i].upper;
      items_[i].idx = static_cast<int>(i);
    }
  }

  BoundingVolumes build() {
    BoundingVolumes result;
    if (items_.empty()) return result;
    const Subtree root = split(0, static_cast<int>(items_.size()), 0);
    result.order.resize(items_.size());
    std::transform(items_.begin(), items_.end(), result.order.begin(),
                   [](const Item& item) { return item.idx; });
    result.nodes.reserve(items_.size() / 2 + 1);
    fold(root, result.nodes);
    return result;
  }

 private:
  /// A binary node splits its run in front of one item, and no other node splits there: the place names the
  /// node, so that branches built in parallel need no common counter.
  Subtree split(int begin, int end, int depth) {
    Subtree result{begin, end, -1, {}};
    if (end - begin <= BoundingVolumes::kLeafSize) {
      for (int i = begin; i < end; ++i) extend(result.box, items_[i].box);
      return result;
    }
    // Past the depth that any sensible input reaches, halves keep the tree shallow.
    const int middle = depth < kHalvesFromDepth ? partition(begin, end) : begin + (end - begin) / 2;
    Subtree left, right;
    const auto split_left = [&] { left = split(begin, middle, depth + 1); };
    const auto split_right = [&] { right = split(middle, end, depth + 1); };
    if (end - begin >= kParallelFrom) {
      tbb::parallel_invoke(split_left, split_right);
    } else {
      split_left();
      split_right();
    }
    halves_[middle] = {left, right};
    extend(result.box, left.box);
    extend(result.box, right.box);
    result.node = middle;
    return result;
  }

  int partition(int begin, int end) {
    const std::span<Item> items(items_.data() + begin, static_cast<std::size_t>(end - begin));
    WideBox centres;
    for (const Item& item : items) {
      const Eigen::Array4f centre = item.box.lower + item.box.upper;
      extend(centres, {centre, centre});
    }
    const Binning binning(centres, end - begin);
    const Split at = find_split(fill_bins(items, binning), binning);
    if (at.axis < 0) return begin + (end - begin) / 2;  // all centres in one place: any halves will do
    const auto goes_left = [&](const Item& item) { return binning.bins_of(item.box)[at.axis] < at.bin; };
    return begin + static_cast<int>(std::partition(items.begin(), items.end(), goes_left) - items.begin());
  }

  /// Appends the node over `subtree`: its largest descendants are opened until there are four.
  int fold(const Subtree& subtree, std::vector<BoxNode>& nodes) const {
    std::vector<Subtree> children{subtree};
    while (children.size() < 4) {
      int widest = -1;
      for (int i = 0; i < static_cast<int>(children.size()); ++i)
        if (children[i].node >= 0 &&
            (widest < 0 || half_area(children[i].box) > half_area(children[widest].box)))
          widest = i;
      if (widest < 0) break;
      const auto [left, right] = halves_[children[widest].node];
      children[widest] = left;
      children.insert(children.begin() + widest + 1, right);
    }
    const int node_idx = static_cast<int>(nodes.size());
    nodes.emplace_back();
    for (int i = 0; i < 4; ++i) {
      const bool present = i < static_cast<int>(children.size());
      const WideBox box = present ? children[i].box : WideBox{};
      const int child = !present               ? ~0
                        : children[i].node < 0 ? ~(children[i].begin << 3 | children[i].size())
                                               : fold(children[i], nodes);
      for (int axis = 0; axis < 3; ++axis) {
        nodes[node_idx].lower[axis][i] = box.lower[axis];
        nodes[node_idx].upper[axis][i] = box.upper[axis];
      }
      nodes[node_idx].child[i] = child;
    }
    return node_idx;
  }

  std::vector<Item> items_;
  std::vector<std::pair<Subtree, Subtree>> halves_;
};

}  // namespace

BoundingVolumes build_bounding_volumes(std::span<const Box> boxes) {
  CONTRACT(boxes.size() < (std::size_t{1} << 28));  // a leaf's first item and count share an int
  return Builder(boxes).build();
}

}  // namespace phiz
