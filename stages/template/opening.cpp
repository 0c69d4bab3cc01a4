#include "stages/template/opening.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

/// A patch lies so much behind what it covers next to its margin, so that a lid that touches an eyeball stays
/// apart.
constexpr double kGroove_mm = 1.0;
constexpr int kRows = 8;  ///< strips of the new surface across the opening

/// Position of a new vertex: where a straight bridge has it, share of the way across, width of the gap there.
using PlaceVertex = std::function<Eigen::Vector3d(const Eigen::Vector3d&, double share, double gap)>;

/// Splits the triangle at border edge a -> b in the middle of that edge.
int split_border_edge(HalfHead& head, int a, int b) {
  const int added = static_cast<int>(head.positions.size());
  for (std::size_t t = 0; t < head.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3i old = head.triangles[t];
      if (old[k] != a || old[(k + 1) % 3] != b) continue;
      head.positions.push_back(0.5 * (head.positions[a] + head.positions[b]));
      head.triangles[t] = {a, added, old[(k + 2) % 3]};
      head.triangles.push_back({added, b, old[(k + 2) % 3]});
      return added;
    }
  }
  throw ContractViolation("no such border edge");
}

/// Splits longest edges of the shorter chain until both have the same number of vertices. `upper` follows the
/// border's half-edges, `lower` runs against them.
void equalise(HalfHead& head, std::vector<int>& upper, std::vector<int>& lower) {
  while (upper.size() != lower.size()) {
    const bool is_upper = upper.size() < lower.size();
    auto& chain = is_upper ? upper : lower;
    std::size_t longest = 0;
    double length = -1;
    for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
      const double l = (head.positions[chain[k]] - head.positions[chain[k + 1]]).norm();
      if (l > length) length = l, longest = k;
    }
    const int a = chain[longest], b = chain[longest + 1];
    const int added = is_upper ? split_border_edge(head, a, b) : split_border_edge(head, b, a);
    chain.insert(chain.begin() + static_cast<std::ptrdiff_t>(longest) + 1, added);
  }
}

/// Bridges two chains that start in one vertex (and may end in one). `upper` follows the border's half-edges.
void bridge(HalfHead& head, const std::vector<int>& upper, const std::vector<int>& lower,
            const PlaceVertex& place) {
  std::vector<std::vector<int>> columns;
  for (std::size_t k = 0; k < upper.size(); ++k) {
    const int a = upper[k], b = lower[k];
    if (a == b) {
      columns.push_back({a});
      continue;
    }
    const Eigen::Vector3d from = head.positions[a], to = head.positions[b];
    std::vector<int> column = {a};
    for (int row = 1; row < kRows; ++row) {
      const double share = static_cast<double>(row) / kRows;
      column.push_back(static_cast<int>(head.positions.size()));
      head.positions.push_back(place((1 - share) * from + share * to, share, (to - from).norm()));
    }
    column.push_back(b);
    columns.push_back(column);
  }
  for (std::size_t k = 0; k + 1 < columns.size(); ++k) {
    const auto &left = columns[k], &right = columns[k + 1];
    for (int row = 0; row < kRows; ++row) {
      const bool left_tip = left.size() == 1, right_tip = right.size() == 1;
      const int a = left[left_tip ? 0 : row], b = left[left_tip ? 0 : row + 1];
      const int c = right[right_tip ? 0 : row], d = right[right_tip ? 0 : row + 1];
      // The border runs left -> right along row 0, so the new triangles run right -> left there.
      if (!right_tip) head.triangles.push_back({c, a, d});
      if (!left_tip) head.triangles.push_back({a, b, d});
    }
  }
}

Eigen::Vector3d area_vector(const HalfHead& head, const std::vector<int>& loop) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < loop.size(); ++k) {
    sum += head.positions[loop[k]].cross(head.positions[loop[(k + 1) % loop.size()]]);
  }
  return -0.5 * sum;  // the border runs clockwise around its opening, seen from outside
}

}  // namespace

void close_patch(HalfHead& head, const std::vector<int>& border, const SurfaceIndex* inside) {
  std::vector<int> loop = border;
  if (loop.size() % 2 == 1) loop.push_back(split_border_edge(head, loop.back(), loop.front()));
  const std::size_t n = loop.size(), half = n / 2;
  std::size_t start = 0;
  double widest = -1e30;
  for (std::size_t k = 0; k < n; ++k) {
    const double width = head.positions[loop[(k + half) % n]][0] - head.positions[loop[k]][0];
    if (width > widest) widest = width, start = k;
  }
  std::vector<int> upper, lower;
  for (std::size_t k = 0; k <= half; ++k) {
    upper.push_back(loop[(start + k) % n]);
    lower.push_back(loop[(start + n - k) % n]);
  }
  const Eigen::Vector3d outward = area_vector(head, loop).normalized();
  bridge(head, upper, lower, [&](const Eigen::Vector3d& p, double share, double gap) -> Eigen::Vector3d {
    if (inside == nullptr) return p;
    const auto hit = inside->find_first_hit(p + 2 * (gap + 1) * outward, -outward, 0, 4 * (gap + 1));
    if (!hit) return p;
    const double margin = std::min(share, 1 - share);  // of the patch
    const double weight = std::min(1.0, 6 * margin);
    const double t = std::clamp((margin - 0.12) / 0.28, 0.0, 1.0);
    const double groove = kGroove_mm * (1 - t * t * (3 - 2 * t));
    return p + weight * (hit->position - p) - groove * outward;
  });
}

void close_pocket(HalfHead& head, const std::vector<int>& run) {
  const auto corner = std::min_element(
      run.begin(), run.end(), [&](int a, int b) { return head.positions[a][0] < head.positions[b][0]; });
  std::vector<int> upper(corner, run.end()), lower(run.begin(), corner + 1);
  std::reverse(lower.begin(), lower.end());
  equalise(head, upper, lower);
  std::vector<int> loop = run;  // closed by its own mirror image: only y and z of the area count
  Eigen::Vector3d outward = area_vector(head, loop);
  outward[0] = 0;
  outward.normalize();
  bridge(head, upper, lower, [&](const Eigen::Vector3d& p, double share, double gap) -> Eigen::Vector3d {
    return p - share * (1 - share) * gap * outward;
  });
}

}  // namespace phiz
