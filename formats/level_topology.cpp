#include "formats/level_topology.h"

#include <algorithm>
#include <string>
#include <utility>

#include "formats/error.h"

namespace phiz {
namespace {

int next_of(int h) {
  return h % 3 == 2 ? h - 2 : h + 1;
}

int before(int h) {
  return h % 3 == 0 ? h + 2 : h - 1;
}

/// Half-edges sorted by the vertices they join; the two of an edge stand side by side.
std::vector<int> match_twins(const std::vector<int>& corners) {
  struct Entry {
    int low, high, half_edge;
    auto operator<=>(const Entry&) const = default;
  };
  std::vector<Entry> entries;
  entries.reserve(corners.size());
  for (int h = 0; h < static_cast<int>(corners.size()); ++h) {
    const int a = corners[h], b = corners[next_of(h)];
    if (a == b) throw FormatError("triangle " + std::to_string(h / 3) + " names a vertex twice");
    entries.push_back({std::min(a, b), std::max(a, b), h});
  }
  std::sort(entries.begin(), entries.end());
  std::vector<int> twins(corners.size(), -1);
  for (std::size_t i = 1; i < entries.size(); ++i) {
    const Entry &x = entries[i - 1], &y = entries[i];
    if (x.low != y.low || x.high != y.high) continue;
    if (twins[x.half_edge] != -1 || corners[x.half_edge] == corners[y.half_edge]) {
      throw FormatError("triangles are no oriented surface (edge " + std::to_string(x.low) + " " +
                        std::to_string(x.high) + ")");
    }
    twins[x.half_edge] = y.half_edge;
    twins[y.half_edge] = x.half_edge;
  }
  return twins;
}

}  // namespace

LevelTopology::LevelTopology(std::span<const Eigen::Vector3i> triangles, std::size_t vertex_count)
    : vertex_count_(vertex_count) {
  corners_.reserve(3 * triangles.size());
  for (const Eigen::Vector3i& triangle : triangles) {
    for (const int corner : triangle) {
      if (corner < 0 || static_cast<std::size_t>(corner) >= vertex_count)
        throw FormatError("corner " + std::to_string(corner) + " is no vertex");
      corners_.push_back(corner);
    }
  }
  twins_ = match_twins(corners_);
  number_edges();
  std::vector<std::pair<int, int>> pairs;  // later, earlier
  for (int h = 0; h < static_cast<int>(corners_.size()); ++h) {
    const int a = corners_[h], b = corners_[next_of(h)];
    if (twins_[h] < h) pairs.emplace_back(std::max(a, b), std::min(a, b));  // each edge once
  }
  std::sort(pairs.begin(), pairs.end());
  offsets_.assign(vertex_count + 1, 0);
  for (const auto& [later, earlier] : pairs) {
    ++offsets_[later + 1];
    earlier_.push_back(earlier);
  }
  for (std::size_t i = 0; i < vertex_count; ++i) offsets_[i + 1] += offsets_[i];
}

void LevelTopology::number_edges() {
  edges_.resize(corners_.size());
  int count = 0;
  for (int h = 0; h < static_cast<int>(corners_.size()); ++h)
    edges_[h] = twins_[h] >= 0 && twins_[h] < h ? edges_[twins_[h]] : count++;
  edge_count_ = static_cast<std::size_t>(count);
}

LevelTopology LevelTopology::next() const {
  LevelTopology fine;
  fine.first_new_ = vertex_count_;
  fine.vertex_count_ = next_vertex_count();
  const int half_edges = static_cast<int>(corners_.size()), base = static_cast<int>(vertex_count_);
  fine.corners_.resize(4 * corners_.size());
  fine.twins_.resize(4 * corners_.size());
  for (int h = 0; h < half_edges; ++h) {
    const int t = h / 3, i = h % 3, child = 3 * (4 * t + i), middle = 3 * (4 * t + 3);
    fine.corners_[child] = corners_[h];
    fine.corners_[child + 1] = base + edges_[h];
    fine.corners_[child + 2] = base + edges_[before(h)];
    fine.corners_[middle + i] = base + edges_[h];
    // The first half of h lies along the second half of its twin, which ends the next child there.
    const int twin = twins_[h], next_child = 3 * (4 * t + (i + 1) % 3) + 2;
    if (twin < 0) {
      fine.twins_[child] = fine.twins_[next_child] = -1;
    } else {
      const int other = 3 * (4 * (twin / 3) + (twin % 3 + 1) % 3) + 2;
      fine.twins_[child] = other;
      fine.twins_[other] = child;
    }
    fine.twins_[child + 1] = middle + (i + 2) % 3;
    fine.twins_[middle + (i + 2) % 3] = child + 1;
  }
  fine.number_edges();
  fine.parents_.reserve(edge_count_);
  fine.offsets_.reserve(edge_count_ + 1);
  fine.earlier_.reserve(2 * edge_count_);
  fine.offsets_.push_back(0);
  for (int h = 0; h < half_edges; ++h) {
    const int edge = edges_[h], twin = twins_[h];
    if (edge != static_cast<int>(fine.parents_.size())) continue;  // not its first half-edge
    fine.parents_.push_back({corners_[h], corners_[next_of(h)]});
    const auto add = [&](int beside) {
      if (edges_[beside] < edge) fine.earlier_.push_back(edges_[beside]);
    };
    add(next_of(h));
    add(before(h));
    if (twin >= 0) {
      add(next_of(twin));
      add(before(twin));
    }
    fine.offsets_.push_back(static_cast<int>(fine.earlier_.size()));
  }
  return fine;
}

}  // namespace phiz
