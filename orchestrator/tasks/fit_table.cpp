#include "orchestrator/tasks/stages.h"
#include "stages/fit/fit.h"

namespace phiz {
namespace {

constexpr Range kWeight = {0, 1e9};
constexpr Range kLength = {0.1, 1000};
constexpr Range kNormals = {0, 1e6};

std::vector<Parameter> describe_stiffness() {
  const GlobalFitOptions defaults;
  return {
      number("smooth_weight_first", defaults.smooth_weight_first, kWeight, "", "lambda of the first round"),
      number("smooth_weight_last", defaults.smooth_weight_last, kWeight, "",
             "lambda of the last stiff round"),
      whole("rounds", defaults.rounds, {1, 1000}, "", "stiffness falls geometrically over these"),
      whole("soft_rounds", defaults.soft_rounds, {0, 1000}, "", "then the shape reached gives way"),
      number("soft_weight", defaults.soft_weight, kWeight, "", "lambda of the soft rounds"),
      number("hidden_weight", defaults.hidden_weight, kWeight, "",
             "lambda of lid and lip hems and of the eyes in the soft rounds"),
      whole("iterations_per_round", defaults.iterations_per_round, {1, 1000}, "", "at most"),
      number("tolerance", defaults.tolerance, {0, 1}, "", "least change of energy for another iteration")};
}

std::vector<Parameter> describe_energies() {
  const GlobalFitOptions defaults;
  return {
      number("binding_weight", defaults.binding_weight, kWeight, "", "mu: behind the ears, between the lips"),
      number("constraint_weight", defaults.constraint_weight, kWeight, "", "nu: the inner lips"),
      number("normal_weight_mm_first", defaults.normal_weight_mm_first, kNormals, "mm",
             "in the first matches"),
      number("normal_weight_mm_last", defaults.normal_weight_mm_last, kNormals, "mm", "in the last matches"),
      number("reach_mm_first", defaults.reach_mm_first, kLength, "mm", "farther first matches are refused"),
      number("reach_mm_last", defaults.reach_mm_last, kLength, "mm", "farther last matches are refused"),
      number("slide_weight", defaults.slide_weight, {0, 1}, "", "share of E_dist along the surface"),
      number("stretch_weight", defaults.stretch_weight, kWeight, "",
             "share of lambda that resists stretching in the region `face`"),
      number("neck_weight", defaults.neck_weight, kWeight, "", "draws the neck loop to the neck plane"),
      choice("eyes", "auto", {"auto", "open", "shut"},
             "of the scan; auto shuts them where shut ones end clearly nearer"),
      number("neck_margin_mm", 1.0, {-100, 100}, "mm", "how far below the neck plane the loop is drawn")};
}

}  // namespace

Task describe_fit_local() {
  const LocalFitOptions defaults;
  Task task;
  task.name = "fit_local";
  task.doc = "ears, nose and mouth of the generic head moved onto the scan";
  task.source = "Jeong et al. 2002, 4.2";
  task.version = 1;
  task.inputs = {output_of("ingest", "cloud.vdb"), output_of("align", "alignment.json"),
                 template_mesh_input(), template_annotations_input()};
  task.outputs = {"local.obj", "fit_local.json"};
  task.summary = "fit_local.json";
  task.parameters = {
      number("reach_mm", defaults.reach_mm, kLength, "mm", "scan farther from a feature does not pull it"),
      number("stretch_weight", defaults.stretch_weight, kWeight, "", "E_stretch against E_dist")
          .from("paper, 4.2"),
      number("blend_mm", defaults.blend_mm, kLength, "mm", "decay of the blend around a feature")
          .from("paper, 4.2"),
      whole("samples", defaults.samples, {10, 1e6}, "", "places a feature is measured at")};
  return task;
}

Task describe_fit_global() {
  Task task;
  task.name = "fit_global";
  task.doc = "the whole control mesh drawn onto the scan, coarse to fine";
  task.source = "Jeong et al. 2002, 4.3";
  task.version = 5;
  task.inputs = {output_of("ingest", "cloud.vdb"), output_of("ingest", "ingest.json"),
                 output_of("fit_local", "local.obj"), template_mesh_input(), template_annotations_input()};
  task.outputs = {"control.obj", "fit_global.json"};
  task.summary = "fit_global.json";
  task.parameters = describe_stiffness();
  for (Parameter& parameter : describe_energies()) task.parameters.push_back(std::move(parameter));
  return task;
}

}  // namespace phiz
