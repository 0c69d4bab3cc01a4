// A Draco file (.drc): one stream, mesh or point cloud.
#include "formats/readers/cloud_builder.h"
#include "formats/readers/draco_geometry.h"
#include "formats/readers/readers.h"

namespace phiz::readers {

ScanFile read_drc(std::span<const std::byte> bytes, const ScanLimits& limits) {
  const DracoGeometry geometry(bytes, 0, {}, limits);
  CloudBuilder builder;
  builder.reserve(geometry.point_count());
  for (std::size_t i = 0; i < geometry.point_count(); ++i) {
    const Eigen::Vector3d p = geometry.position(i);
    builder.add_position(p.x(), p.y(), p.z());
    if (geometry.has_normals()) {
      const Eigen::Vector3d n = geometry.normal(i);
      builder.add_normal(n.x(), n.y(), n.z());
    }
    if (geometry.has_colours()) {
      const Eigen::Vector3d c = geometry.colour(i);
      builder.add_colour(c.x(), c.y(), c.z());
    }
  }
  builder.scan.triangles.reserve(geometry.triangle_count());
  for (std::size_t i = 0; i < geometry.triangle_count(); ++i)
    builder.scan.triangles.push_back(geometry.triangle(i));
  return builder.finish("drc", ColourRange::numbers);
}

}  // namespace phiz::readers
