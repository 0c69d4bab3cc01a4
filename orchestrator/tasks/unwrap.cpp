#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "orchestrator/tasks/head_unwrap.h"
#include "orchestrator/tasks/kept_outputs.h"
#include "orchestrator/tasks/nouns.h"
#include "orchestrator/tasks/stages.h"

namespace phiz {

namespace {

void make_image(TaskContext& context, const HeadUnwrap& head, const PointCloud& cloud,
                const UnwrapOptions& options, KeptOutputs& kept) {
  const GeometryImage image = head.geometry_image(&cloud, options);
  context.progress(0.4);
  double seen = 0;
  for (const float mask : image.mask) seen += mask;
  const nlohmann::ordered_json summary = {{"side", options.side},
                                          {"has_colours", cloud.has_colours()},
                                          {"colour_seen", seen / static_cast<double>(image.node_count())}};
  std::ostringstream out;
  write_geometry_image(image, out);
  kept.write("unwrap.json", format_json_output(summary));
  kept.write("geometry.exr", std::move(out).str());
}

}  // namespace

void run_unwrap(TaskContext& context) {
  UnwrapOptions options;
  options.side = context.whole("side");
  options.colours.reach_mm = context.number("colour_reach_mm");
  options.colours.spread_mm = context.number("colour_spread_mm");

  std::unique_ptr<HeadUnwrap> head;
  with_place(context.describe_input("head.glb"),
             [&] { head = std::make_unique<HeadUnwrap>(context.read_input("head.glb")); });
  const PointCloud cloud = load_cloud(context, "cloud.vdb");
  context.progress(0.2);
  KeptOutputs kept(context);
  if (kept.write_kept("geometry.exr")) {
    kept.write_kept("unwrap.json");  // written before it
  } else {
    make_image(context, *head, cloud, options, kept);
  }
  context.progress(0.6);
  Image texture{1, 1, {{128, 128, 128}}};
  if (cloud.has_colours()) {
    texture = to_srgb(bake_texture(head->surface(), cloud, options));
  } else {
    context.note("the scan has no colours: texture.png is one grey pixel");
  }
  save(context, "texture.png", [&](std::ostream& out) { write_png(texture, out); });
  context.progress(1);
}

}  // namespace phiz
