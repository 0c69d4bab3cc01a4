#include "orchestrator/tasks/stages.h"
#include "stages/align/align.h"

namespace phiz {

Task describe_align() {
  const AlignOptions defaults;
  Task task;
  task.name = "align";
  task.doc = "affine transform of the generic head by its silhouettes along three axes";
  task.source = "Jeong et al. 2002, 4.1";
  task.version = 1;
  task.inputs = {output_of("ingest", "cloud.vdb"), output_of("ingest", "ingest.json"), template_mesh_input(),
                 template_annotations_input()};
  task.outputs = {"alignment.json", "silhouettes.png"};
  task.summary = "alignment.json";
  task.parameters = {
      {"coarse_size_px",
       std::int64_t{defaults.coarse_size},
       "pixels",
       "side of the pictures of the first search",
       "the paper's 256",
       64,
       4096,
       {},
       ""},
      {"fine_size_px",
       std::int64_t{defaults.fine_size},
       "pixels",
       "side of the pictures of the second search",
       "the paper's 512",
       64,
       4096,
       {},
       ""},
      {"relative_tolerance",
       defaults.relative_tolerance,
       "",
       "of Powell's method: least gain of a round",
       "",
       1e-9,
       0.5,
       {},
       ""},
      {"max_evaluations",
       std::int64_t{defaults.max_evaluations},
       "",
       "most silhouette counts of each search",
       "",
       1,
       1e6,
       {},
       ""},
      {"pose_weight",
       defaults.pose_weight,
       "",
       "what leaving the pose of ingest costs, as a share of the covered pixels; 0: outlines alone",
       "",
       0,
       100,
       {},
       ""},
      {"clip_back",
       std::string("auto"),
       "",
       "leave out what lies behind the back plane; auto: where the scan has no back",
       "",
       0,
       0,
       {"auto", "true", "false"},
       ""}};
  return task;
}

}  // namespace phiz
