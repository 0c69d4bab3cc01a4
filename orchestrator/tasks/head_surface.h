#pragma once

#include <optional>
#include <string>
#include <vector>

#include "formats/image.h"
#include "formats/triangle_mesh.h"

namespace phiz {

struct HeadSurfaceOptions {
  std::optional<int> level;    ///< 0 .. 8; absent: the asset's finest. Beyond it the surface is smooth
  bool in_scan_frame = false;  ///< the scan's own frame and units instead of mm in the head frame
};

/// The surface of a head asset (the bytes of a head.glb) with normals and (u,v). Throws FormatError,
/// UsageError.
TriangleMesh evaluate_head(const std::string& asset_bytes, const HeadSurfaceOptions& options);

/// Front, three-quarter, side and back of a mesh in the head frame, side by side.
Image draw_head(const TriangleMesh& mesh);

}  // namespace phiz
