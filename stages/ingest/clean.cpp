#include "stages/ingest/clean.h"

#include <algorithm>
#include <numeric>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "stages/geometry/point_grid.h"
#include "stages/geometry/point_index.h"

namespace phiz {
namespace {

template <class T>
void keep_rows(std::vector<T>& rows, const std::vector<char>& keep) {
  if (rows.empty()) return;
  std::size_t n = 0;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (keep[i]) rows[n++] = rows[i];
  rows.resize(n);
}

int find_root(std::vector<int>& parent, int i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

/// Point count of the heap (26-connected cells) that each cell belongs to.
std::vector<int> heap_sizes(const PointGrid& grid) {
  const auto& dims = grid.dimensions();
  std::vector<int> parent(grid.cell_count());
  std::iota(parent.begin(), parent.end(), 0);
  const auto occupied = [&](std::size_t c) { return grid.cell_end(c) > grid.cell_begin(c); };
  for (int z = 0; z < dims.z(); ++z)
    for (int y = 0; y < dims.y(); ++y)
      for (int x = 0; x < dims.x(); ++x) {
        const std::size_t here = grid.cell_index({x, y, z});
        if (!occupied(here)) continue;
        for (int n = 0; n < 13; ++n) {  // the half of the 26 neighbours that comes before
          const Eigen::Vector3i c(x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1);
          if (!grid.contains(c) || !occupied(grid.cell_index(c))) continue;
          const int a = find_root(parent, static_cast<int>(here)),
                    b = find_root(parent, static_cast<int>(grid.cell_index(c)));
          parent[std::max(a, b)] = std::min(a, b);
        }
      }
  std::vector<int> size(grid.cell_count(), 0), result(grid.cell_count(), 0);
  for (std::size_t c = 0; c < result.size(); ++c)
    if (occupied(c)) size[find_root(parent, static_cast<int>(c))] += grid.cell_end(c) - grid.cell_begin(c);
  for (std::size_t c = 0; c < result.size(); ++c)
    if (occupied(c)) result[c] = size[find_root(parent, static_cast<int>(c))];
  return result;
}

}  // namespace

std::size_t keep_points(PointCloud& cloud, const std::vector<char>& keep) {
  CONTRACT(keep.size() == cloud.size());
  const std::size_t before = cloud.size();
  keep_rows(cloud.normals, keep);
  keep_rows(cloud.colours, keep);
  keep_rows(cloud.confidences, keep);
  keep_rows(cloud.positions, keep);
  return before - cloud.size();
}

std::vector<char> find_supported(std::span<const Eigen::Vector3f> positions_mm, float radius_mm) {
  const PointGrid grid(positions_mm, radius_mm);
  const auto heaps = heap_sizes(grid);
  const int least = static_cast<int>(positions_mm.size() / 500);
  std::vector<char> keep(positions_mm.size(), 0);
  parallel_for(grid.cell_count(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      if (heaps[c] < least) continue;
      const bool crowded = grid.cell_end(c) - grid.cell_begin(c) > 32;
      for (int slot = grid.cell_begin(c); slot < grid.cell_end(c); ++slot) {
        int neighbours = -1;  // the point finds itself
        if (!crowded)
          grid.for_each_within(grid.sorted_points()[slot], radius_mm, [&](int, float) { ++neighbours; });
        keep[grid.order()[slot]] = crowded || neighbours >= 3;
      }
    }
  });
  return keep;
}

float median_spacing(std::span<const Eigen::Vector3f> positions) {
  const PointIndex index(positions);
  std::vector<float> distances;
  std::vector<PointIndex::Neighbour> near;
  const std::size_t step = std::max<std::size_t>(1, positions.size() / 500);
  for (std::size_t i = 0; i < positions.size(); i += step) {
    index.find_nearest(positions[i], 7, near);
    distances.push_back(std::sqrt(near.back().squared_distance));
  }
  std::nth_element(distances.begin(), distances.begin() + distances.size() / 2, distances.end());
  return distances[distances.size() / 2];
}

}  // namespace phiz
