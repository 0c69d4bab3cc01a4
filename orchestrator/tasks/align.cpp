#include "stages/align/align.h"

#include <nlohmann/json.hpp>

#include "formats/image.h"
#include "orchestrator/error.h"
#include "orchestrator/tasks/nouns.h"
#include "orchestrator/tasks/stages.h"

namespace phiz {
namespace {

constexpr std::array<std::uint8_t, 3> kNeither = {255, 255, 255}, kBoth = {190, 190, 190},
                                      kScanOnly = {200, 60, 40}, kHeadOnly = {40, 90, 200};

/// Front, side and top: grey where scan and generic head agree, red scan alone, blue head alone.
Image draw_silhouettes(const AlignResult& result) {
  const int size = result.frame.size;
  Image image;
  image.width = 3 * size;
  image.height = size;
  image.pixels.assign(static_cast<std::size_t>(image.width) * size, kNeither);
  for (int view = 0; view < 3; ++view) {
    const Silhouette& cloud = result.cloud_silhouettes[view];
    const Silhouette& model = result.model_silhouettes[view];
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        const bool in_cloud = cloud.covers(x, y), in_model = model.covers(x, y);
        if (!in_cloud && !in_model) continue;
        image.at(view * size + x, y) = in_cloud && in_model ? kBoth : in_cloud ? kScanOnly : kHeadOnly;
      }
    }
  }
  return image;
}

AlignOptions read_options(const TaskContext& context) {
  AlignOptions options;
  options.coarse_size = context.whole("coarse_size_px");
  options.fine_size = context.whole("fine_size_px");
  if (options.coarse_size % 64 != 0 || options.fine_size % 64 != 0) {
    throw UsageError("align: sizes of pictures must be multiples of 64");
  }
  options.relative_tolerance = context.number("relative_tolerance");
  options.max_evaluations = context.whole("max_evaluations");
  options.pose_weight = context.number("pose_weight");
  if (context.text("clip_back") != "auto") options.clip_back = context.text("clip_back") == "true";
  return options;
}

}  // namespace

void run_align(TaskContext& context) {
  const AlignOptions options = read_options(context);
  const auto head = load_generic_head(context);
  const double head_scale = load_json(context, "ingest.json").at("head_scale").get<double>();
  const AlignResult result = align(load_cloud(context, "cloud.vdb"), *head, head_scale, options);
  const double covered = std::max<double>(1, static_cast<double>(result.covered_pixels));
  context.progress(1, static_cast<double>(result.white_pixels_after) / covered);
  save_json(context, "alignment.json",
            {{"head_from_model", to_json(result.head_from_model)},
             {"scales", {result.scales.x(), result.scales.y(), result.scales.z()}},
             {"white_pixels_before", result.white_pixels_before},
             {"white_pixels_after", result.white_pixels_after},
             {"covered_pixels", result.covered_pixels},
             {"evaluations", result.evaluations},
             {"clipped_back", result.clipped_back},
             {"point_size_px", result.point_size_px}});
  save(context, "silhouettes.png", [&](std::ostream& out) { write_png(draw_silhouettes(result), out); });
}

}  // namespace phiz
