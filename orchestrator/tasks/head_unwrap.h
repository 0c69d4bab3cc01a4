#pragma once

#include <memory>
#include <optional>
#include <string>

#include "formats/geometry_image.h"
#include "formats/head_asset.h"
#include "formats/point_cloud.h"
#include "stages/unwrap/unwrap.h"

namespace phiz {

/// A fitted head over (u,v): the asset's own (u,v), its finest level.
class HeadUnwrap {
 public:
  /// `asset_bytes` of a head.glb. Throws FormatError, InvalidInput.
  explicit HeadUnwrap(const std::string& asset_bytes);
  explicit HeadUnwrap(HeadAsset asset);

  const UvSurface& surface() const { return *surface_; }
  /// `cloud` may be null; without colours the image has none.
  GeometryImage geometry_image(const PointCloud* cloud, const UnwrapOptions& options) const;

 private:
  HeadAsset asset_;
  std::unique_ptr<UvChart> chart_;
  std::unique_ptr<UvSurface> surface_;
};

}  // namespace phiz
