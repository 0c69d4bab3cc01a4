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
  task.version = 1;
  task.inputs = {output_of("ingest", "cloud.vdb"), output_of("ingest", "ingest.json"),
                 output_of("fit_global", "control.obj"), template_mesh_input(), template_annotations_input()};
  task.outputs = {"head.glb", "subdivide.json"};
  task.summary = "subdivide.json";
  task.parameters = {
      {"levels",
       std::int64_t{4},
       "",
       "finest level of the asset",
       "paper, 5: level 4 is 4^4 times the control mesh",
       0,
       8,
       {},
       "--levels"},
      {"bandwidth_mm",
       0.8,
       "mm",
       "least radius of the local surface that is measured",
       "measured: noise of 0.1-0.3 mm",
       0.05,
       50,
       {},
       ""},
      {"bandwidth_spacing", 0.25, "", "its least radius as a share of the edge length", "", 0, 10, {}, ""},
      {"reach_mm", 3.0, "mm", "farthest displacement that is measured", "", 0.1, 100, {}, ""},
      {"reach_spacing",
       0.6,
       "",
       "farthest displacement beyond 1 mm as a share of the edge length",
       "",
       0,
       10,
       {},
       ""},
      {"bridge_rings",
       defaults.bridge_rings,
       "rings",
       "unmeasured vertices this near to measured ones are bridged",
       "",
       0,
       100,
       {},
       ""},
      {"max_slope",
       defaults.max_slope,
       "",
       "most difference of displacements along an edge, as a share of its length",
       "",
       0.01,
       100,
       {},
       ""},
      {"displacement_step_mm",
       file_defaults.displacement_step_mm,
       "mm",
       "quantisation of displacements in head.glb",
       "",
       1e-5,
       10,
       {},
       ""},
      {"position_step_mm",
       file_defaults.position_step_mm,
       "mm",
       "quantisation of control vertices in head.glb",
       "",
       1e-4,
       10,
       {},
       ""}};
  return task;
}

}  // namespace phiz
