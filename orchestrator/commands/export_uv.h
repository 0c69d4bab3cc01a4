#pragma once

#include <optional>
#include <string>

#include "formats/point_cloud.h"

namespace phiz {

/// What `phiz export` writes over (u,v): `.exr` a geometry image; with `wants_texture` a `.png` (sRGB) or
/// `.exr` (linear, with alpha) of the colours. Throws UsageError, FormatError.
std::string make_uv_file(const std::string& extension, bool wants_texture, std::optional<int> side,
                         const std::string& asset_bytes, const PointCloud& cloud);

}  // namespace phiz
