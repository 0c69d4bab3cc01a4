#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "orchestrator/tasks/nouns.h"
#include "orchestrator/tasks/stages.h"
#include "stages/fit/fit.h"

namespace phiz {

void run_fit_local(TaskContext& context) {
  LocalFitOptions options;
  options.reach_mm = context.number("reach_mm");
  options.stretch_weight = context.number("stretch_weight");
  options.blend_mm = context.number("blend_mm");
  options.samples = context.whole("samples");

  const auto head = load_generic_head(context);
  Eigen::Affine3d head_from_model;
  head_from_model.matrix() = matrix_from_json(load_json(context, "alignment.json").at("head_from_model"));
  ControlPositions aligned = head->positions;
  for (Eigen::Vector3d& position : aligned) position = head_from_model * position;

  const auto scan = load_scan_surface(context, "cloud.vdb");
  context.progress(0.3);
  const LocalFitResult result = fit_local(*scan, *head, aligned, options);
  context.progress(1);
  auto boxes = nlohmann::ordered_json::array();
  for (const LocalFitBox& box : result.boxes) {
    boxes.push_back({{"name", box.name},
                     {"energy_before", box.energy_before},
                     {"energy_after", box.energy_after},
                     {"evaluations", box.evaluations},
                     {"applied", box.applied}});
  }
  save_control_positions(context, "local.obj", result.positions);
  save_json(context, "fit_local.json", {{"boxes", boxes}});
}

}  // namespace phiz
