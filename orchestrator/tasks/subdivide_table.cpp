#include "formats/head_asset.h"
#include "orchestrator/tasks/stages.h"
#include "stages/subdivide/subdivide.h"

namespace phiz {

Task describe_subdivide() {
  const DisplacementOptions defaults;
  const HeadAssetOptions file_defaults;
  Task task;
  task.name = "subdivide";
  task.doc = "Modified Butterfly levels, each displaced along its normals onto the scan";
  task.source = "Jeong et al. 2002, 5";
  task.version = 6;
  task.inputs = {output_of("ingest", "cloud.vdb"), output_of("ingest", "ingest.json"),
                 output_of("fit_global", "control.obj"), template_mesh_input(), template_annotations_input()};
  task.outputs = {"head.glb", "subdivide.json"};
  task.summary = "subdivide.json";
  task.parameters = {
      whole("levels", 4, {0, 8}, "", "finest level of the asset").from("paper, 5").with_option("--levels"),
      number("bandwidth_mm", 1.1, {0.05, 50}, "mm", "least radius of the local surface that is measured"),
      number("bandwidth_spacing", 0.25, {0, 10}, "", "its least radius as a share of the edge length"),
      number("reach_mm", 3, {0.1, 100}, "mm", "farthest displacement that is measured"),
      number("reach_spacing", 0.6, {0, 10}, "",
             "farthest displacement beyond 1 mm as a share of the edge length"),
      number("bridge_rings", defaults.bridge_rings, {0, 100}, "rings",
             "unmeasured vertices so near are bridged"),
      number("max_slope", defaults.max_slope, {0.01, 100}, "",
             "most difference of displacements over an edge's length"),
      number("displacement_step_mm", file_defaults.displacement_step_mm, {1e-5, 10}, "mm",
             "step of displacements in head.glb"),
      number("position_step_mm", file_defaults.position_step_mm, {1e-4, 10}, "mm",
             "step of control vertices in head.glb")};
  return task;
}

}  // namespace phiz
