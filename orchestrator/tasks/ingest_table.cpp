#include "orchestrator/tasks/stages.h"
#include "stages/ingest/ingest.h"

namespace phiz {

Task describe_ingest() {
  const IngestOptions defaults;
  Task task;
  task.name = "ingest";
  task.doc = "raw scan to a clean, upright head in mm, cut at the neck";
  task.source = "stages/ingest/ingest.h";
  task.version = 1;
  task.inputs = {scan_input(), template_mesh_input(), template_annotations_input()};
  task.outputs = {"cloud.vdb", "distance.vdb", "ingest.json"};
  task.summary = "ingest.json";
  task.parameters = {
      {"units",
       std::string("auto"),
       "",
       "unit of the scan; auto finds it from the size of the head",
       "",
       0,
       0,
       {"auto", "mm", "cm", "m", "in"},
       "--units"},
      {"soup_samples",
       std::int64_t{defaults.soup_samples},
       "points",
       "points drawn by area from a scan with triangles",
       "the paper's clouds have 50,000 points; 300,000 keep pores",
       1000,
       50e6,
       {},
       ""},
      {"max_points",
       std::int64_t{defaults.max_points},
       "points",
       "larger clouds are thinned evenly; 0 keeps all",
       "",
       0,
       1e9,
       {},
       ""},
      {"neck_margin_mm",
       defaults.neck_margin_mm,
       "mm",
       "how far below the generic head's neck plane points are kept",
       "",
       -200,
       1000,
       {},
       ""},
      {"field_voxel_mm", defaults.field_voxel_mm, "mm", "lattice of the distance field", "", 0.2, 20, {}, ""},
      {"reject_score",
       defaults.reject_score,
       "",
       "pose score (0 perfect, 1 nothing fits) above which it is no head",
       "measured on scans of heads and of other things",
       0,
       1,
       {},
       ""}};
  return task;
}

}  // namespace phiz
