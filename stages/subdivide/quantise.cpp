#include "stages/subdivide/quantise.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "stages/subdivide/level_surface.h"
#include "stages/subdivide/quantise_target.h"

namespace phiz {
namespace {

constexpr std::size_t kGrain = 1024;
constexpr double kAim = 0.95;        ///< of the tolerance is aimed at: a few samples always miss the aim
constexpr double kFirstStep = 1.95;  ///< of the aim: 2 would leave nothing for what normals turn
constexpr int kFineSteps = 2;        ///< small steps in one of the others
constexpr int kMostRounds = 6, kRepairSweeps = 3;
constexpr std::size_t kFewVertices = 300;  ///< to be mended one by one

std::vector<Eigen::Vector3d> round_positions(std::span<const Eigen::Vector3d> positions, double step) {
  std::vector<Eigen::Vector3d> rounded;
  rounded.reserve(positions.size());
  for (const Eigen::Vector3d& p : positions) {
    Eigen::Vector3d q;
    for (int k = 0; k < 3; ++k) q[k] = static_cast<float>(std::floor(p[k] / step + 0.5) * step);
    rounded.push_back(q);
  }
  return rounded;
}

/// The way along `normal`, in whole steps, that brings a vertex best to the given surface: next to its own
/// place there, or, where what turned the normal leaves that out of reach, nearest to the surface.
double choose_way(const QuantiseTarget& target, const Eigen::Vector3d& position,
                  const Eigen::Vector3d& normal, int vertex_idx, double step, double tolerance_mm) {
  const Eigen::Vector3d& place = target.position(vertex_idx);
  const double straight = std::floor((place - position).dot(normal) / step + 0.5);
  if ((position + straight * step * normal - place).norm() <= 0.98 * tolerance_mm) return straight;
  const double met = std::floor(target.find_way(position, normal, vertex_idx) / step + 0.5);
  double best = std::numeric_limits<double>::infinity(), chosen = straight;
  for (const double steps : {straight, straight - 1, straight + 1, met}) {
    const Eigen::Vector3d moved = position + steps * step * normal;
    const double error = std::max(target.distance(moved), 0.95 * tolerance_mm) + 0.1 * (moved - place).norm();
    if (error < best) {
      best = error;
      chosen = steps;
    }
  }
  return chosen;
}

/// One pass over all levels; returns the finest positions. Vertices marked as fine are rounded to the small
/// steps, the others to whole ones of kFineSteps each.
std::vector<Eigen::Vector3d> quantise_with(const SubdivisionHierarchy& hierarchy,
                                           const QuantiseTarget& target, const QuantiseOptions& options,
                                           const std::vector<char>& is_fine, QuantisedSurface& surface) {
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(hierarchy.vertex_count(options.level));
  positions.assign(surface.control_positions.begin(), surface.control_positions.end());
  surface.displacements_mm.clear();
  for (int level = 0; level <= options.level; ++level) {
    if (level > 0) refine_positions(hierarchy, level, positions);
    const int first = first_displaced(hierarchy, level);
    const std::vector<Eigen::Vector3d> normals = displacement_normals(hierarchy, level, positions);
    std::vector<float> displacements(positions.size(), 0.0f);
    parallel_for(normals.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const int vertex = first + static_cast<int>(i), small = is_fine[vertex] ? 1 : kFineSteps;
        const double steps = small * choose_way(target, positions[vertex], normals[i], vertex,
                                                small * surface.step_mm, options.tolerance_mm);
        displacements[vertex] = static_cast<float>(steps * surface.step_mm);
      }
    });
    displace_along(normals, displacements, positions);
    surface.displacements_mm.push_back(std::move(displacements));
  }
  return positions;
}

/// Marks all that vertices of the finest level and those beside them were born of.
void mark_fine(const SubdivisionHierarchy& hierarchy, int finest, const std::vector<int>& vertices,
               std::vector<char>& is_fine) {
  std::vector<char> found(is_fine.size(), 0);
  for (const int vertex : vertices) found[vertex] = 1;
  const std::vector<char> given = found;
  for (const Eigen::Vector3i& t : hierarchy.triangles(finest)) {
    if (given[t[0]] || given[t[1]] || given[t[2]]) found[t[0]] = found[t[1]] = found[t[2]] = 1;
  }
  for (int level = finest; level > 0; --level) {
    for (int v = hierarchy.vertex_count(level - 1); v < hierarchy.vertex_count(level); ++v) {
      if (!found[v]) continue;
      for (const int parent : hierarchy.parents(level, v)) found[parent] = 1;
    }
  }
  const int count = first_displaced(hierarchy, finest);
  for (int v = 0; v < count; ++v) is_fine[v] |= found[v];
}

/// Moves single vertices of the last level by small steps while that brings the surfaces nearer around them.
/// Returns what is still too far.
HausdorffSamples repair(const SubdivisionHierarchy& hierarchy, const QuantiseTarget& target,
                        const QuantiseOptions& options, HausdorffSamples samples, QuantisedSurface& surface) {
  const std::vector<Eigen::Vector3i>& triangles = hierarchy.triangles(options.level);
  const int first = first_displaced(hierarchy, options.level);
  std::vector<float>& displacements = surface.displacements_mm.back();
  std::vector<Eigen::Vector3d> bases(surface.positions.begin(), surface.positions.begin() + first);
  if (options.level > 0) refine_positions(hierarchy, options.level, bases);
  if (options.level == 0) bases = surface.control_positions;
  const std::vector<Eigen::Vector3d> normals = displacement_normals(hierarchy, options.level, bases);
  for (int sweep = 0; sweep < kRepairSweeps && !samples.vertices.empty(); ++sweep) {
    for (const int vertex : samples.vertices) {
      if (vertex < first) continue;
      const double steps = std::floor(displacements[vertex] / surface.step_mm + 0.5);
      double best = std::numeric_limits<double>::infinity(), chosen = steps;
      const auto move_to = [&](double to) {
        displacements[vertex] = static_cast<float>(to * surface.step_mm);
        surface.positions[vertex] = bases[vertex] + double{displacements[vertex]} * normals[vertex - first];
      };
      for (const int move : {0, -1, 1, -2, 2, -4, 4}) {
        move_to(steps + move);
        const double error = target.local_error(surface.positions, vertex);
        if (error >= best) continue;
        best = error;
        chosen = steps + move;
      }
      move_to(chosen);
    }
    samples = measure_samples(target, surface.positions, triangles, options.tolerance_mm);
  }
  return samples;
}

}  // namespace

double measure_hausdorff(std::span<const Eigen::Vector3d> first, std::span<const Eigen::Vector3d> second,
                         std::span<const Eigen::Vector3i> triangles) {
  CONTRACT(first.size() == second.size());
  return measure_samples(QuantiseTarget(first, triangles), second, triangles, 0).most_mm;
}

QuantisedSurface quantise_surface(const SubdivisionHierarchy& hierarchy,
                                  std::span<const Eigen::Vector3d> control_positions,
                                  std::span<const std::vector<float>> displacements_mm,
                                  const QuantiseOptions& asked) {
  QuantiseOptions options = asked;
  options.tolerance_mm *= kAim;
  if (!(asked.tolerance_mm >= 1e-4 && asked.tolerance_mm <= 5))
    throw InvalidInput("a tolerance is from 0.0001 to 5 mm");
  if (!(options.position_step_mm >= 1e-4 && options.position_step_mm <= 10))
    throw InvalidInput("a step of positions is from 0.0001 to 10 mm");
  CONTRACT(options.level >= 0 && options.level <= hierarchy.level_count());
  const std::vector<Eigen::Vector3d> given =
      evaluate_surface(hierarchy, control_positions, displacements_mm, options.level);
  const QuantiseTarget target(given, hierarchy.triangles(options.level));
  QuantisedSurface surface;
  surface.position_step_mm = options.position_step_mm;
  surface.step_mm = kFirstStep * options.tolerance_mm / kFineSteps;
  std::vector<char> is_fine(given.size(), 0);
  QuantisedSurface best;
  for (int round = 0; round < kMostRounds; ++round) {
    surface.control_positions = round_positions(control_positions, surface.position_step_mm);
    surface.positions = quantise_with(hierarchy, target, options, is_fine, surface);
    HausdorffSamples samples =
        measure_samples(target, surface.positions, hierarchy.triangles(options.level), options.tolerance_mm);
    if (!samples.vertices.empty() && samples.vertices.size() < kFewVertices)
      samples = repair(hierarchy, target, options, std::move(samples), surface);
    surface.hausdorff_mm = samples.most_mm;
    if (samples.most_mm <= asked.tolerance_mm) return surface;
    if (round == 0 || surface.hausdorff_mm < best.hausdorff_mm) best = surface;
    mark_fine(hierarchy, options.level, samples.vertices, is_fine);
  }
  return best;
}

}  // namespace phiz
