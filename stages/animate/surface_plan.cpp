#include "stages/animate/surface_plan.h"

#include <algorithm>
#include <array>

#include "stages/geometry/error.h"
#include "stages/geometry/half_edge.h"

namespace phiz {
namespace {

using Level = SurfacePlan::Level;

/// The butterfly's entries in the order in which the kernel adds them: halves, eighths, sixteenths, each as
/// they come. False where the row is another one.
bool find_regular_row(const SubdivisionHierarchy::Stencils& stencils, int row,
                      std::array<int, SurfacePlan::kRowLength>& entries) {
  const int begin = stencils.offsets[row], end = stencils.offsets[row + 1];
  if (end - begin != SurfacePlan::kRowLength) return false;
  int halves = 0, eighths = 0, sixteenths = 0;
  for (int i = begin; i < end; ++i) {
    const double weight = stencils.weights[i];
    const int vertex = stencils.vertices[i] * SurfacePlan::kPointBytes;
    if (weight == 0.5 && halves < 2)
      entries[halves++] = vertex;
    else if (weight == 0.125 && eighths < 2)
      entries[2 + eighths++] = vertex;
    else if (weight == -0.0625 && sixteenths < 4)
      entries[4 + sixteenths++] = vertex;
    else
      return false;
  }
  return true;
}

void add_rows(const SubdivisionHierarchy::Stencils& stencils, Level& level) {
  level.rows.assign(static_cast<std::size_t>(level.count) * SurfacePlan::kRowLength, 0);
  level.general_offsets.assign(1, 0);
  for (int row = 0; row < level.count; ++row) {
    std::array<int, SurfacePlan::kRowLength> entries{};
    if (!find_regular_row(stencils, row, entries)) {
      entries.fill(0);
      entries[0] = -static_cast<int>(level.general_offsets.size());
      for (int i = stencils.offsets[row]; i < stencils.offsets[row + 1]; ++i) {
        level.general_points.push_back(stencils.vertices[i] * SurfacePlan::kPointBytes);
        level.general_weights.push_back(static_cast<float>(stencils.weights[i]));
      }
      level.general_offsets.push_back(static_cast<int>(level.general_points.size()));
    }
    std::copy(entries.begin(), entries.end(),
              level.rows.begin() + static_cast<std::ptrdiff_t>(row) * SurfacePlan::kRowLength);
  }
}

/// Compressed lists: `entries` are (list, value) in any order; within a list values keep their order.
void compress(int list_count, const std::vector<std::pair<int, int>>& entries, std::vector<int>& offsets,
              std::vector<int>& values) {
  offsets.assign(static_cast<std::size_t>(list_count) + 1, 0);
  for (const auto& entry : entries) ++offsets[entry.first + 1];
  for (int i = 0; i < list_count; ++i) offsets[i + 1] += offsets[i];
  std::vector<int> next(offsets.begin(), offsets.end() - 1);
  values.resize(entries.size());
  for (const auto& [list, value] : entries) values[next[list]++] = value;
}

void add_dependents(const SubdivisionHierarchy& hierarchy, int k, Level& level) {
  const SubdivisionHierarchy::Stencils& stencils = hierarchy.stencils(k);
  std::vector<std::pair<int, int>> entries;
  entries.reserve(stencils.vertices.size());
  for (int row = 0; row < level.count; ++row) {
    const auto begin = stencils.vertices.begin() + stencils.offsets[row];
    const auto end = stencils.vertices.begin() + stencils.offsets[row + 1];
    for (auto i = begin; i != end; ++i) entries.emplace_back(*i, level.first + row);
    // A parent without weight still turns the normal.
    const SubdivisionHierarchy::Ring& ring = hierarchy.rings(k)[row];
    for (const int parent : {ring[0], ring[3]})
      if (std::find(begin, end, parent) == end) entries.emplace_back(parent, level.first + row);
  }
  compress(level.first, entries, level.dependent_offsets, level.dependents);
}

/// From neighbours to the fans that name them; the vertex itself comes first.
void add_fans(int raw_offset, Level& level) {
  std::vector<std::pair<int, int>> entries;
  const int width = level.spokes_per_vertex;
  for (int v = 0; v < level.count; ++v) entries.emplace_back(v, level.first + v);
  for (int v = 0; v < level.count; ++v) {
    const auto begin = level.spokes.begin() + static_cast<std::ptrdiff_t>(v) * width;
    for (auto i = begin; i != begin + width; ++i) {
      const int neighbour = *i / SurfacePlan::kPointBytes - raw_offset - level.first;
      if (neighbour < 0 || neighbour == v || std::find(begin, i, *i) != i) continue;
      entries.emplace_back(neighbour, level.first + v);
    }
  }
  compress(level.count, entries, level.fan_offsets, level.fans);
}

void add_control_spokes(const SubdivisionHierarchy& hierarchy, int raw_offset, Level& level) {
  const HalfEdgeMesh mesh(hierarchy.triangles(0), level.count);
  std::vector<std::vector<int>> rings(level.count);
  std::size_t width = SurfacePlan::kSpokesAbove0;
  for (int v = 0; v < level.count; ++v) {
    if (mesh.outgoing(v) != HalfEdgeMesh::kNone) rings[v] = mesh.ring(v);
    width = std::max(width, rings[v].size() + (mesh.is_border_vertex(v) ? 1 : 0));
  }
  level.spokes_per_vertex = static_cast<int>(width);
  for (int v = 0; v < level.count; ++v) {
    const bool is_open = rings[v].empty() || mesh.is_border_vertex(v);
    for (std::size_t i = 0; i < width; ++i) {
      const int spoke = i < rings[v].size() ? rings[v][i] : is_open ? v : rings[v][0];
      level.spokes.push_back((raw_offset + spoke) * SurfacePlan::kPointBytes);
    }
  }
}

/// Parents are final, their other neighbours are not displaced yet.
void add_spokes(const SubdivisionHierarchy& hierarchy, int k, int raw_offset, Level& level) {
  level.spokes.reserve(static_cast<std::size_t>(level.count) * SurfacePlan::kSpokesAbove0);
  for (int row = 0; row < level.count; ++row) {
    const SubdivisionHierarchy::Ring& ring = hierarchy.rings(k)[row];
    for (int i = 0; i < SurfacePlan::kSpokesAbove0; ++i) {
      const bool is_parent = i == 0 || i == 3;
      const int neighbour = ring[i] < 0 ? level.first + row : ring[i];
      level.spokes.push_back((is_parent ? neighbour : raw_offset + neighbour) * SurfacePlan::kPointBytes);
    }
  }
}

}  // namespace

SurfacePlan::SurfacePlan(const SubdivisionHierarchy& hierarchy) {
  const int finest = hierarchy.level_count();
  const int raw_offset = hierarchy.vertex_count(finest);
  CONTRACT(raw_offset < (1 << 26));  // offsets in bytes are ints
  levels_.resize(static_cast<std::size_t>(finest) + 1);
  for (int k = 0; k <= finest; ++k) {
    Level& level = levels_[k];
    level.first = k == 0 ? 0 : hierarchy.vertex_count(k - 1);
    level.count = hierarchy.vertex_count(k) - level.first;
    if (k == 0) {
      add_control_spokes(hierarchy, raw_offset, level);
    } else {
      add_rows(hierarchy.stencils(k), level);
      add_dependents(hierarchy, k, level);
      add_spokes(hierarchy, k, raw_offset, level);
    }
    add_fans(raw_offset, level);
  }
  add_supports();
}

namespace {

/// A set of vertices that remembers its members.
struct Marks {
  explicit Marks(int vertex_count) : stamps(vertex_count, -1) {}
  void add(int vertex_idx, int stamp) {
    if (stamps[vertex_idx] == stamp) return;
    stamps[vertex_idx] = stamp;
    list.push_back(vertex_idx);
  }
  std::vector<int> stamps, list;
};

}  // namespace

void SurfacePlan::add_supports() {
  const int last = std::min(level_count(), kSupportLevels - 1);
  Marks refined(vertex_count(last)), displaced(vertex_count(last));
  support_offsets_.assign(1, 0);
  const auto keep = [&](std::vector<int>& list, std::size_t from) {
    std::sort(list.begin() + static_cast<std::ptrdiff_t>(from), list.end());
    supports_.insert(supports_.end(), list.begin() + static_cast<std::ptrdiff_t>(from), list.end());
    support_offsets_.push_back(static_cast<int>(supports_.size()));
  };
  for (int v = 0; v < vertex_count(0); ++v) {
    displaced.list.clear();
    for (int k = 0; k < kSupportLevels; ++k) {
      refined.list.clear();
      const std::size_t before = displaced.list.size();
      if (k == 0) refined.add(v, v);
      if (k > 0 && k <= last) {
        const Level& level = levels_[k];
        for (const int moved : displaced.list)
          for (int j = level.dependent_offsets[moved]; j < level.dependent_offsets[moved + 1]; ++j)
            refined.add(level.dependents[j], v);
      }
      for (const int moved : refined.list) {
        const Level& level = levels_[k];
        for (int j = level.fan_offsets[moved - level.first]; j < level.fan_offsets[moved - level.first + 1];
             ++j)
          displaced.add(level.fans[j], v);
      }
      keep(refined.list, 0);
      keep(displaced.list, before);
    }
  }
}

SurfacePlan::Support SurfacePlan::support(int control_vertex_idx, int level) const {
  const std::size_t at = 2 * (static_cast<std::size_t>(control_vertex_idx) * kSupportLevels + level);
  const std::span<const int> all(supports_);
  return {all.subspan(support_offsets_[at], support_offsets_[at + 1] - support_offsets_[at]),
          all.subspan(support_offsets_[at + 1], support_offsets_[at + 2] - support_offsets_[at + 1])};
}

}  // namespace phiz
