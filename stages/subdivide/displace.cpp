#include <algorithm>
#include <cmath>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "stages/subdivide/displacement_field.h"
#include "stages/subdivide/level_surface.h"
#include "stages/subdivide/subdivide.h"

namespace phiz {
namespace {

constexpr std::size_t kMeasureGrain = 256;
constexpr double kLargestDisplacementMm = 1e6;  ///< beyond it, or not a number: not measured
constexpr double kLeastTurnDot = 0.5;           ///< displacement turns no triangle by more than 60 degrees
constexpr std::uint8_t kMeasuredFully = 255, kBridgedConfidence = 128;

/// The field as measured, and the confidences of what was.
struct Measured {
  DisplacementField field;
  std::vector<std::uint8_t> confidences;
};

Measured measure_level(const DisplacementGraph& graph, const Eigen::Vector3d* positions,
                       const std::vector<Eigen::Vector3d>& normals, const std::vector<char>& measurable,
                       const MeasureSurface& measure) {
  const std::size_t count = normals.size(), first = measurable.size() - count;
  Measured result;
  result.field.values.assign(count, 0.0);
  result.field.states.assign(count, DisplacementField::kUnknown);
  result.confidences.assign(count, 0);
  parallel_for(count, kMeasureGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (!measurable[first + i]) {
        result.field.states[i] = DisplacementField::kHeld;
        continue;
      }
      if (normals[i].squaredNorm() < 0.5) continue;  // no triangle here has an area
      const SurfaceMeasurement found = measure(positions[i], normals[i], graph.spacings[i]);
      if (!(found.confidence > 0) || !(std::abs(found.displacement_mm) <= kLargestDisplacementMm)) continue;
      result.field.values[i] = found.displacement_mm;
      result.field.states[i] = DisplacementField::kMeasured;
      const double byte = std::nearbyint(kMeasuredFully * std::min(found.confidence, 1.0));
      result.confidences[i] = static_cast<std::uint8_t>(std::max(byte, 1.0));
    }
  });
  return result;
}

/// A vertex beside one that may not be measured may not be either.
void extend_measurable(const SubdivisionHierarchy& hierarchy, int level, std::vector<char>& measurable) {
  for (const SubdivisionHierarchy::Ring& ring : hierarchy.rings(level))
    measurable.push_back(measurable[ring[3]] && measurable[ring[0]]);
}

/// Confidences of the whole level. What was not measured at this level, nor bridged, rests on its parents: it
/// lies on the smooth surface between them, which is as good as a bridge where both are known.
std::vector<std::uint8_t> complete_confidences(const SubdivisionHierarchy& hierarchy, int level,
                                               const Measured& measured,
                                               const std::vector<std::uint8_t>& coarse) {
  std::vector<std::uint8_t> all(coarse);
  all.reserve(coarse.size() + measured.confidences.size());
  for (std::size_t i = 0; i < measured.confidences.size(); ++i) {
    const DisplacementField::State state = measured.field.states[i];
    std::uint8_t confidence = measured.confidences[i];
    if (state == DisplacementField::kBridged) confidence = kBridgedConfidence;
    if (state == DisplacementField::kUnknown && level > 0) {
      const SubdivisionHierarchy::Ring& ring = hierarchy.rings(level)[i];
      confidence = std::min({coarse[ring[3]], coarse[ring[0]], kBridgedConfidence});
    }
    all.push_back(confidence);
  }
  return all;
}

double compute_rms(const DisplacementField& field) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < field.values.size(); ++i) {
    if (field.states[i] != DisplacementField::kMeasured) continue;
    sum += field.values[i] * field.values[i];
    ++count;
  }
  return count == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(count));
}

}  // namespace

DisplacedSurface displace(const SubdivisionHierarchy& hierarchy,
                          std::span<const Eigen::Vector3d> control_positions,
                          const std::vector<bool>& measurable, const MeasureSurface& measure,
                          const DisplacementOptions& options) {
  CONTRACT(static_cast<int>(control_positions.size()) == hierarchy.vertex_count(0));
  CONTRACT(measurable.size() == control_positions.size());
  CONTRACT(options.bridge_rings >= 0 && options.max_slope > 0);
  DisplacedSurface surface;
  surface.positions.reserve(hierarchy.vertex_count(hierarchy.level_count()));
  surface.positions.assign(control_positions.begin(), control_positions.end());
  std::vector<char> may_measure(measurable.begin(), measurable.end());
  const int rings = static_cast<int>(std::min(options.bridge_rings, 1e6));
  for (int level = 0; level <= hierarchy.level_count(); ++level) {
    if (level > 0) {
      refine_positions(hierarchy, level, surface.positions);
      extend_measurable(hierarchy, level, may_measure);
    }
    const int first = first_displaced(hierarchy, level);
    const std::vector<Eigen::Vector3d> normals = displacement_normals(hierarchy, level, surface.positions);
    const DisplacementGraph graph = build_displacement_graph(hierarchy, level, surface.positions);
    Measured measured = measure_level(graph, surface.positions.data() + first, normals, may_measure, measure);
    reject_spikes(graph, options.max_slope, measured.field);
    cap_slopes(graph, options.max_slope, measured.field);
    bridge_gaps(graph, rings, measured.field);
    limit_turns(hierarchy.triangles(level), surface.positions, normals, kLeastTurnDot, measured.field);

    std::vector<float> displacements(surface.positions.size(), 0.0f);
    for (std::size_t i = 0; i < normals.size(); ++i)
      displacements[first + i] = static_cast<float>(measured.field.values[i]);
    displace_along(normals, displacements, surface.positions);
    surface.confidences.push_back(complete_confidences(
        hierarchy, level, measured, level == 0 ? std::vector<std::uint8_t>{} : surface.confidences.back()));
    surface.displacements_mm.push_back(std::move(displacements));
    surface.rms_displacement_mm.push_back(compute_rms(measured.field));
  }
  return surface;
}

}  // namespace phiz
