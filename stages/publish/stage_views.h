#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "formats/image.h"
#include "formats/point_cloud.h"
#include "formats/triangle_mesh.h"
#include "stages/geometry/scan_surface.h"
#include "stages/publish/views.h"

namespace phiz {

/// One row of a sheet: a cloud or a mesh (exactly one), drawn once a column.
struct SheetRow {
  std::string label;  ///< under the row's first picture, before the column's
  const PointCloud* cloud = nullptr;
  const TriangleMesh* mesh = nullptr;
  std::optional<HeatMap> heat = {};  ///< one value a point or vertex; its legend stands at the row's end
  Light light = Light::kSoft;
  float point_size_mm = 0;  ///< as in ViewOptions
  bool use_colours = false, wireframe = false, flat = false;
};

/// One column: where one looks from, and at what. All rows are framed alike.
struct SheetColumn {
  std::string label;  ///< under the picture
  Camera camera;
  Eigen::AlignedBox3f frame_mm;
};

struct SheetOptions {
  int width = 360, height = 440;  ///< pixels of a picture, [8, 8192]
  std::string title;              ///< on top
  std::vector<Image> extra = {};  ///< a last row of pictures made elsewhere
  std::vector<std::string> extra_labels = {};
};

/// Front, side, three-quarter and back of the same frame, which holds the cloud but for points far away.
std::vector<SheetColumn> make_round_columns(const PointCloud& cloud);

/// A sheet of pictures in one grid. Same input, same bytes, at any thread count. Throws InvalidInput as
/// render_mesh does. 0.1 s a picture of 300,000 points or of 600,000 triangles.
Image draw_sheet(const std::vector<SheetRow>& rows, const std::vector<SheetColumn>& columns,
                 const SheetOptions& options);

/// Distance in mm from each point to the surface, at most `most_mm`; NaN for points that are not finite.
std::vector<float> compute_distances(const PointCloud& cloud, const TriangleMesh& surface, double most_mm);

/// Distance in mm from each vertex to the scan's local surface (the mean of its noisy points), along the
/// vertex's own normal; NaN where nothing was scanned within `most_mm`. The mesh must have normals.
std::vector<float> compute_offsets(const TriangleMesh& mesh, const ScanSurface& scan, double most_mm);

/// A strip of `count` pictures of equal width as single pictures, each reduced by a whole factor until it is
/// no wider than `most_width`.
std::vector<Image> split_strip(const Image& strip, int count, int most_width);

}  // namespace phiz
