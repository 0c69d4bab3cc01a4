#include "stages/subdivide/subdivide.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "formats/head_asset.h"
#include "orchestrator/tasks/nouns.h"
#include "orchestrator/tasks/stages.h"
#include "stages/geometry/annotations.h"

namespace phiz {
namespace {

constexpr double kLeastReachMm = 1.0;

MeasureSurface make_measure(const TaskContext& context, const ScanSurface& scan) {
  const double bandwidth_mm = context.number("bandwidth_mm"),
               bandwidth_spacing = context.number("bandwidth_spacing");
  const double reach_mm = context.number("reach_mm"), reach_spacing = context.number("reach_spacing");
  return [=, &scan](const Eigen::Vector3d& position, const Eigen::Vector3d& normal, double spacing_mm) {
    const double bandwidth = std::max(bandwidth_mm, bandwidth_spacing * spacing_mm);
    const double reach = std::min(reach_mm, kLeastReachMm + reach_spacing * spacing_mm);
    const ScanSurface::Measurement measurement =
        scan.measure(position.cast<float>(), normal.cast<float>(), static_cast<float>(bandwidth),
                     static_cast<float>(reach));
    return SurfaceMeasurement{measurement.offset_mm, measurement.confidence};
  };
}

/// Shares of the finest level's vertices that were measured, bridged and invented.
nlohmann::ordered_json count_confidences(const std::vector<std::uint8_t>& confidences) {
  constexpr std::uint8_t kMeasured = 192, kBridged = 64;
  double measured = 0, bridged = 0;
  for (const std::uint8_t confidence : confidences) {
    measured += confidence >= kMeasured;
    bridged += confidence >= kBridged && confidence < kMeasured;
  }
  const double count = std::max<double>(1, static_cast<double>(confidences.size()));
  return {{"measured", measured / count},
          {"bridged", bridged / count},
          {"invented", (count - measured - bridged) / count}};
}

}  // namespace

void run_subdivide(TaskContext& context) {
  const auto head = load_generic_head(context);
  const auto hierarchy = load_hierarchy(context, context.whole("levels"));
  const auto scan = load_scan_surface(context, "cloud.vdb");
  const std::vector<Eigen::Vector3d> control = load_control_positions(context, "control.obj");
  std::vector<bool> measurable;
  for (const char not_measurable : find_unmeasurable(*head)) measurable.push_back(!not_measurable);

  DisplacementOptions options;
  options.bridge_rings = context.number("bridge_rings");
  options.max_slope = context.number("max_slope");
  DisplacedSurface surface = displace(*hierarchy, control, measurable, make_measure(context, *scan), options);
  context.progress(0.8);

  HeadAsset asset;
  asset.template_digest = context.template_digest().hex();
  for (const Eigen::Vector3d& position : control) asset.positions.push_back(position.cast<float>());
  asset.triangles = head->triangles;
  for (const Eigen::Vector2d& uv : head->uv) asset.uv.push_back(uv.cast<float>());
  asset.displacements_mm = std::move(surface.displacements_mm);
  asset.confidences = std::move(surface.confidences);
  const nlohmann::ordered_json ingest = load_json(context, "ingest.json");
  asset.scan_from_head = matrix_from_json(ingest.at("scan_from_head"));
  const HeadAssetOptions file_options{context.number("displacement_step_mm"),
                                      context.number("position_step_mm")};
  save(context, "head.glb", [&](std::ostream& out) { write_head_asset(asset, file_options, out); });
  save_json(context, "subdivide.json",
            {{"levels", hierarchy->level_count()},
             {"vertices", hierarchy->vertex_count(hierarchy->level_count())},
             {"rms_displacement_mm", surface.rms_displacement_mm},
             {"confidence", count_confidences(asset.confidences.back())},
             {"scan_from_head", ingest.at("scan_from_head")}});
  context.progress(1);
}

}  // namespace phiz
