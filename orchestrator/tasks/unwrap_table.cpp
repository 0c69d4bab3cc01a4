#include "orchestrator/tasks/stages.h"

namespace phiz {

Task describe_unwrap() {
  Task task;
  task.name = "unwrap";
  task.doc = "the head over its (u,v) square: positions, normals, colours, confidence as an image";
  task.source = "Gu, Gortler, Hoppe 2002; ours";
  task.version = 1;
  task.option = "--unwrap";
  task.inputs = {output_of("subdivide", "head.glb"), output_of("ingest", "cloud.vdb")};
  task.outputs = {"geometry.exr", "texture.png", "unwrap.json"};
  task.summary = "unwrap.json";
  task.parameters = {
      whole("side", 512, {16, 8192}, "nodes", "of the geometry image, and pixels of the texture, a side"),
      number("colour_reach_mm", 2.5, {0.01, 100}, "mm", "points farther away give no colour"),
      number("colour_spread_mm", 0.5, {0.01, 100}, "mm", "sigma of the weights of colours")};
  return task;
}

}  // namespace phiz
