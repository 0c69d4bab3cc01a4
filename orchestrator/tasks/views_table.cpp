#include "orchestrator/tasks/stages.h"

namespace phiz {

Task describe_views() {
  Task task;
  task.name = "views";
  task.doc = "pictures of what each stage made beside the scan, with distances in colour";
  task.source = "ours";
  task.version = 2;
  task.option = "--views";
  task.inputs = {output_of("ingest", "cloud.vdb"),
                 output_of("align", "alignment.json"),
                 output_of("align", "silhouettes.png"),
                 output_of("fit_local", "local.obj"),
                 output_of("fit_global", "control.obj"),
                 output_of("subdivide", "head.glb"),
                 template_mesh_input(),
                 template_annotations_input()};
  task.outputs = {"ingest.png",     "align.png",     "fit_local.png",
                  "fit_global.png", "subdivide.png", "closeups.png"};
  task.parameters = {
      whole("width_px", 360, {64, 2000}, "pixels", "width of one picture of a sheet"),
      number("heat_high_mm", 1, {0.001, 1000}, "mm", "dark end of the distances after the fit"),
      number("early_heat_high_mm", 10, {0.001, 1000}, "mm",
             "dark end of the distances before the global fit")};
  return task;
}

}  // namespace phiz
