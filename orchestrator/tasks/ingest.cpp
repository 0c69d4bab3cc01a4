#include "stages/ingest/ingest.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "formats/distance_field.h"
#include "formats/scan_file.h"
#include "orchestrator/tasks/ingest_state.h"
#include "orchestrator/tasks/nouns.h"
#include "orchestrator/tasks/stages.h"

namespace phiz {
namespace {

std::optional<double> mm_per_unit(const std::string& unit) {
  if (unit == "mm") return 1.0;
  if (unit == "cm") return 10.0;
  if (unit == "m") return 1000.0;
  if (unit == "in") return 25.4;
  return std::nullopt;
}

ScanFile load_scan(TaskContext& context) {
  const std::string bytes = context.read_input("scan");
  ScanFile scan;
  with_place(context.describe_input("scan"),
             [&] { scan = parse_scan(std::as_bytes(std::span(bytes)), context.scan_extension()); });
  return scan;
}

nlohmann::ordered_json to_json(const IngestSummary& summary) {
  return {{"points_read", summary.points_read},
          {"points_sampled", summary.points_sampled},
          {"points_kept", summary.points_kept},
          {"removed_non_finite", summary.removed_non_finite},
          {"removed_outliers", summary.removed_outliers},
          {"removed_below_neck", summary.removed_below_neck},
          {"removed_far", summary.removed_far},
          {"unit", summary.unit},
          {"mm_per_unit", summary.mm_per_unit},
          {"head_scale", summary.head_scale},
          {"pose_score", summary.pose_score},
          {"pose_mismatch", summary.pose_mismatch},
          {"turned_deg", summary.turned_deg},
          {"coverage", summary.coverage},
          {"noise_mm", summary.noise_mm},
          {"density_per_mm2", summary.density_per_mm2}};
}

void tell(TaskContext& context, const IngestSummary& summary) {
  context.note(fmt::format(
      "{} points, unit {} ({:.4g} mm), turned by {:.0f} degrees, {:.0f} % of the head seen",
      summary.points_read, summary.unit, summary.mm_per_unit, summary.turned_deg, 100 * summary.coverage));
  context.note(fmt::format("kept {}, removed {} outliers, {} below the neck, {} far away, {} not finite",
                           summary.points_kept, summary.removed_outliers, summary.removed_below_neck,
                           summary.removed_far, summary.removed_non_finite));
}

/// A state is as large as the cloud: it is saved where that is little beside what would be lost.
void save_if_worth(TaskContext& context, const IngestState& state) {
  constexpr double kWorthSaving_s = 1;
  if (!context.checkpoint_due(kWorthSaving_s) && !context.stop_requested()) return;
  const std::string bytes = encode_ingest_state(state);
  context.save_checkpoint(std::as_bytes(std::span(bytes)));
}

IngestResult ingest_in_steps(TaskContext& context, const ControlMesh& head, const IngestOptions& options) {
  std::optional<IngestState> state;
  if (const auto bytes = context.load_checkpoint()) state = decode_ingest_state(*bytes);
  if (!state) {
    const ScanFile scan = load_scan(context);
    context.progress(0.1);
    state = place_head(scan, head, options);
    save_if_worth(context, *state);
  }
  context.progress(0.5);
  if (!state->cloud.has_normals()) {
    orient_points(head, *state);
    save_if_worth(context, *state);
  }
  context.progress(0.8);
  return finish_ingest(head, options, std::move(*state));
}

}  // namespace

void run_ingest(TaskContext& context) {
  IngestOptions options;
  options.mm_per_unit = mm_per_unit(context.text("units"));
  options.soup_samples = context.whole("soup_samples");
  options.max_points = context.whole("max_points");
  options.neck_margin_mm = context.number("neck_margin_mm");
  options.field_voxel_mm = context.number("field_voxel_mm");
  options.reject_score = context.number("reject_score");
  options.reject_mismatch = context.number("reject_mismatch");

  const auto head = load_generic_head(context);
  const IngestResult result = ingest_in_steps(context, *head, options);
  context.progress(0.9);
  tell(context, result.summary);
  save(context, "cloud.vdb", [&](std::ostream& out) { write_vdb(result.cloud, out); });
  save(context, "distance.vdb", [&](std::ostream& out) { write_vdb(result.distance_field, out); });
  nlohmann::ordered_json summary = to_json(result.summary);
  summary["scan_from_head"] = to_json(result.scan_from_head);
  save_json(context, "ingest.json", summary);
}

}  // namespace phiz
