#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/image.h"
#include "formats/point_cloud.h"
#include "formats/triangle_mesh.h"

namespace phiz {

/// Orthographic camera on a sphere around the frame's centre. Azimuth 0 looks at the face (along -z), 90 sees
/// the subject's left profile (camera on +x); positive elevation looks from above. Degrees, as people say
/// them.
struct Camera {
  double azimuth_deg = 0;
  double elevation_deg = 0;
};

/// "front", "left", "right", "side" (= left), "threequarter", "threequarter-right", "back", "top", "under".
std::optional<Camera> find_camera(std::string_view name);

enum class Light {
  kSoft,  ///< key from upper left, fill, rim: for looking at shapes
  kSide,  ///< one light that grazes the surface from the left: shows ripples and steps
  kNone,  ///< colours as they are
};

enum class ColourMap {
  kSequential,  ///< pale to dark red, even in lightness: distances
  kDiverging,   ///< blue, white, red: signed quantities
};

/// One scalar per vertex or point, drawn in colour. NaN is grey: no data. A strip with the legend is added on
/// the right of the picture, which is then wider than ViewOptions says.
struct HeatMap {
  std::vector<float> values;
  float low = 0, high = 1;  ///< the ends of the legend; values beyond them take the end's colour
  ColourMap map = ColourMap::kSequential;
  std::string caption;  ///< above the legend: quantity and unit
};

struct ViewOptions {
  Camera camera;
  int width = 600, height = 700;  ///< pixels, [8, 8192]
  std::optional<Eigen::AlignedBox3f>
      frame_mm;  ///< what must be in the picture; absent: the object's own (without outliers, for points)
  Light light = Light::kSoft;
  bool use_colours = false;     ///< the object's own colours where it has some, else clay
  std::optional<HeatMap> heat;  ///< stronger than use_colours
  bool wireframe = false;       ///< edges of visible triangles
  bool flat = false;            ///< one normal a triangle instead of smooth ones
  float point_size_mm = 0;      ///< splat diameter; 0: from the cloud's density
  std::array<std::uint8_t, 3> clay = {205, 190, 178};
  std::array<std::uint8_t, 3> background = {250, 250, 250};
  std::string label;  ///< written into the upper left corner
};

/// Pictures for people, drawn in software: the same input gives the same bytes on every machine and at any
/// thread count. The scale is the same on both axes and, with a frame given, the same at every azimuth.
/// Triangles seen from behind are tinted violet, so that holes and folds show. Normals are the mesh's own, or
/// averaged by area where it has none. 3 x 3 samples a pixel. Vertices that are not finite are left out with
/// their triangles. Throws InvalidInput on sizes out of range, on indices out of range, and where heat values
/// do not match. 650,000 triangles at 600 x 700 take about 0.2 s of processor time, 300,000 points about 0.3
/// s.
Image render_mesh(const TriangleMesh& mesh, const ViewOptions& options);

/// The same for points, as discs facing the viewer. Shaded by the cloud's normals, or by the relief of the
/// picture itself where it has none. Points that are not finite are left out.
Image render_points(const PointCloud& cloud, const ViewOptions& options);

/// Rows of pictures, each centred in the cell of its column, with a label under each (rows of labels may be
/// short or empty) and a title line on top where there is one.
Image contact_sheet(const std::vector<std::vector<Image>>& rows,
                    const std::vector<std::vector<std::string>>& labels, const std::string& title = {});

}  // namespace phiz
