#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "orchestrator/tasks/fit_state.h"
#include "orchestrator/tasks/nouns.h"
#include "orchestrator/tasks/stages.h"
#include "stages/fit/fit.h"

namespace phiz {
namespace {

constexpr int kHierarchyLevels = 2;  // distances are measured on the subdivided surface

GlobalFitOptions read_options(TaskContext& context, const ControlMesh& head) {
  GlobalFitOptions options;
  options.smooth_weight_first = context.number("smooth_weight_first");
  options.smooth_weight_last = context.number("smooth_weight_last");
  options.rounds = context.whole("rounds");
  options.soft_rounds = context.whole("soft_rounds");
  options.soft_weight = context.number("soft_weight");
  options.hidden_weight = context.number("hidden_weight");
  options.iterations_per_round = context.whole("iterations_per_round");
  options.tolerance = context.number("tolerance");
  options.binding_weight = context.number("binding_weight");
  options.constraint_weight = context.number("constraint_weight");
  options.normal_weight_mm_first = context.number("normal_weight_mm_first");
  options.normal_weight_mm_last = context.number("normal_weight_mm_last");
  options.reach_mm_first = context.number("reach_mm_first");
  options.reach_mm_last = context.number("reach_mm_last");
  options.slide_weight = context.number("slide_weight");
  options.stretch_weight = context.number("stretch_weight");
  options.neck_weight = context.number("neck_weight");
  const std::string eyes = context.text("eyes");
  options.eyes = eyes == "open" ? Eyes::kOpen : eyes == "shut" ? Eyes::kShut : Eyes::kAsTheScan;
  const auto neck = head.annotations.clipping_planes.find("neck");
  if (neck == head.annotations.clipping_planes.end()) {
    throw FormatError(context.describe_input("template.json") + ": it has no clipping plane 'neck'");
  }
  const double head_scale = load_json(context, "ingest.json").at("head_scale").get<double>();
  options.neck = neck->second;
  options.neck->offset_mm = neck->second.offset_mm * head_scale - context.number("neck_margin_mm");
  return options;
}

}  // namespace

void run_fit_global(TaskContext& context) {
  const auto head = load_generic_head(context);
  const auto hierarchy = load_hierarchy(context, kHierarchyLevels);
  const auto scan = load_scan_surface(context, "cloud.vdb");
  const GlobalFitOptions options = read_options(context, *head);
  const ControlPositions start = load_control_positions(context, "local.obj");

  std::optional<GlobalFitState> resumed;
  if (const auto bytes = context.load_checkpoint()) resumed = decode_fit_state(*bytes, start.size());
  const GlobalFitProgress tell = [&](const GlobalFitState& state) {
    if (context.checkpoint_due() || context.stop_requested()) {
      const std::string bytes = encode_fit_state(state);
      context.save_checkpoint(std::as_bytes(std::span(bytes)));
    }
    const double done = state.round * options.iterations_per_round + state.iteration;
    std::optional<double> energy;
    if (!state.energies.empty()) energy = state.energies.back();
    context.progress(done / ((options.rounds + options.soft_rounds) * options.iterations_per_round), energy);
    return true;
  };
  const GlobalFitResult result =
      fit_global(*scan, *head, *hierarchy, start, options, resumed ? &*resumed : nullptr, tell);
  save_control_positions(context, "control.obj", result.positions);
  save_json(context, "fit_global.json",
            {{"iterations", result.energies.size()},
             {"energies", result.energies},
             {"mean_distance_mm", result.mean_distance_mm},
             {"matched_share", result.matched_share},
             {"eyes", result.eyes_shut ? "shut" : "open"}});
}

}  // namespace phiz
