#include "orchestrator/commands/export_uv.h"

#include <sstream>

#include "formats/image.h"
#include "orchestrator/error.h"
#include "orchestrator/tasks/head_unwrap.h"

namespace phiz {

std::string make_uv_file(const std::string& extension, bool wants_texture, std::optional<int> side,
                         const std::string& asset_bytes, const PointCloud& cloud) {
  UnwrapOptions options;
  options.side = side.value_or(options.side);
  if (options.side < 16 || options.side > 8192) throw UsageError("--size is not from 16 to 8192");
  if (wants_texture && !cloud.has_colours()) throw UsageError("the scan has no colours to make a texture of");
  const HeadUnwrap head(asset_bytes);
  std::ostringstream out;
  if (!wants_texture) {
    write_geometry_image(head.geometry_image(&cloud, options), out);
  } else {
    const FloatImage texture = bake_texture(head.surface(), cloud, options);
    if (extension == ".exr") {
      write_exr(texture, out);
    } else {
      write_png(to_srgb(texture), out);
    }
  }
  return std::move(out).str();
}

}  // namespace phiz
