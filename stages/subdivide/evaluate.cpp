#include <string>

#include "stages/geometry/error.h"
#include "stages/geometry/normals.h"
#include "stages/geometry/parallel.h"
#include "stages/subdivide/level_surface.h"
#include "stages/subdivide/ring_normals.h"
#include "stages/subdivide/subdivide.h"

namespace phiz {
namespace {

constexpr std::size_t kGrain = 4096;

}  // namespace

void refine_positions(const SubdivisionHierarchy& hierarchy, int level,
                      std::vector<Eigen::Vector3d>& positions) {
  const SubdivisionHierarchy::Stencils& stencils = hierarchy.stencils(level);
  const std::size_t old_count = positions.size(), new_count = stencils.offsets.size() - 1;
  positions.resize(old_count + new_count);
  parallel_for(new_count, kGrain, [&](std::size_t begin, std::size_t end) {
    const Eigen::Vector3d* coarse = positions.data();
    for (std::size_t row = begin; row < end; ++row) {
      double x = 0, y = 0, z = 0;
      for (int i = stencils.offsets[row]; i < stencils.offsets[row + 1]; ++i) {
        const Eigen::Vector3d& p = coarse[stencils.vertices[i]];
        const double weight = stencils.weights[i];
        x += weight * p.x();
        y += weight * p.y();
        z += weight * p.z();
      }
      positions[old_count + row] = {x, y, z};
    }
  });
}

std::vector<Eigen::Vector3d> displacement_normals(const SubdivisionHierarchy& hierarchy, int level,
                                                  const std::vector<Eigen::Vector3d>& positions) {
  if (level == 0) return compute_vertex_normals(positions, hierarchy.triangles(0));
  const std::span<const SubdivisionHierarchy::Ring> rings = hierarchy.rings(level);
  const auto centres = std::span<const Eigen::Vector3d>(positions).last(rings.size());
  std::vector<Eigen::Vector3d> normals(rings.size());
  parallel_for(rings.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    compute_ring_normals(positions, centres.subspan(begin, end - begin), rings.subspan(begin, end - begin),
                         std::span<Eigen::Vector3d>(normals).subspan(begin, end - begin));
  });
  return normals;
}

void displace_along(const std::vector<Eigen::Vector3d>& normals, const std::vector<float>& displacements_mm,
                    std::vector<Eigen::Vector3d>& positions) {
  const std::size_t first = positions.size() - normals.size();
  parallel_for(normals.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      positions[first + i] += double{displacements_mm[first + i]} * normals[i];
  });
}

std::vector<Eigen::Vector3d> evaluate_surface(const SubdivisionHierarchy& hierarchy,
                                              std::span<const Eigen::Vector3d> control_positions,
                                              std::span<const std::vector<float>> displacements_mm,
                                              int level) {
  CONTRACT(level >= 0 && level <= hierarchy.level_count());
  CONTRACT(static_cast<int>(control_positions.size()) == hierarchy.vertex_count(0));
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(hierarchy.vertex_count(level));
  positions.assign(control_positions.begin(), control_positions.end());
  for (int k = 0; k <= level; ++k) {
    if (k > 0) refine_positions(hierarchy, k, positions);
    if (k >= static_cast<int>(displacements_mm.size()) || displacements_mm[k].empty()) continue;
    if (displacements_mm[k].size() != positions.size())
      throw InvalidInput("level " + std::to_string(k) + " has " + std::to_string(positions.size()) +
                         " vertices and " + std::to_string(displacements_mm[k].size()) + " displacements");
    displace_along(displacement_normals(hierarchy, k, positions), displacements_mm[k], positions);
  }
  return positions;
}

std::vector<Eigen::Vector2d> evaluate_uv(const SubdivisionHierarchy& hierarchy,
                                         std::span<const Eigen::Vector2d> control_uv, int level) {
  CONTRACT(level >= 0 && level <= hierarchy.level_count());
  CONTRACT(static_cast<int>(control_uv.size()) == hierarchy.vertex_count(0));
  std::vector<Eigen::Vector2d> uv;
  uv.reserve(hierarchy.vertex_count(level));
  uv.assign(control_uv.begin(), control_uv.end());
  for (int k = 1; k <= level; ++k)
    for (const SubdivisionHierarchy::Ring& ring : hierarchy.rings(k))
      uv.push_back(0.5 * (uv[ring[3]] + uv[ring[0]]));
  return uv;
}

}  // namespace phiz
