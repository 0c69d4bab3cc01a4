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
      whole("coarse_size_px", defaults.coarse_size, {64, 4096}, "pixels",
            "side of the first search's pictures")
          .from("the paper's 256"),
      whole("fine_size_px", defaults.fine_size, {64, 4096}, "pixels", "side of the second search's pictures")
          .from("the paper's 512"),
      number("relative_tolerance", defaults.relative_tolerance, {1e-9, 0.5}, "",
             "of Powell's method: least gain of a round"),
      whole("max_evaluations", defaults.max_evaluations, {1, 1e6}, "",
            "most silhouette counts of each search"),
      number("pose_weight", defaults.pose_weight, {0, 100}, "",
             "what leaving the pose of ingest costs; 0: outlines alone"),
      choice("clip_back", "auto", {"auto", "true", "false"},
             "leave out what is behind the back plane; auto: if unseen")};
  return task;
}

}  // namespace phiz
