#include "orchestrator/tasks/stages.h"
#include "stages/ingest/ingest.h"

namespace phiz {

Task describe_ingest() {
  const IngestOptions defaults;
  Task task;
  task.name = "ingest";
  task.doc = "raw scan to a clean, upright head in mm, cut at the neck";
  task.source = "stages/ingest/ingest.h";
  task.version = 2;
  task.inputs = {scan_input(), template_mesh_input(), template_annotations_input()};
  task.outputs = {"cloud.vdb", "distance.vdb", "ingest.json"};
  task.summary = "ingest.json";
  task.parameters = {
      choice("units", "auto", {"auto", "mm", "cm", "m", "in"},
             "unit of the scan; auto finds it from the head's size")
          .with_option("--units"),
      whole("soup_samples", defaults.soup_samples, {1000, 5e7}, "points",
            "drawn by area from a scan with triangles"),
      whole("max_points", defaults.max_points, {0, 1e9}, "points",
            "larger clouds are thinned evenly; 0 keeps all"),
      number("neck_margin_mm", defaults.neck_margin_mm, {-200, 1000}, "mm",
             "points are kept so far below the neck plane"),
      number("field_voxel_mm", defaults.field_voxel_mm, {0.2, 20}, "mm", "lattice of the distance field"),
      number("reject_mismatch", defaults.reject_mismatch, {0, 1}, "",
             "the same for the sharpened pose, with normals"),
      number("reject_score", defaults.reject_score, {0, 1}, "",
             "pose score above which it is no head (0 is perfect)")};
  return task;
}

}  // namespace phiz
