#include "orchestrator/tasks/head_surface.h"

#include <Eigen/Geometry>
#include <sstream>

#include "formats/head_asset.h"
#include "orchestrator/error.h"
#include "stages/geometry/normals.h"
#include "stages/publish/views.h"
#include "stages/subdivide/subdivide.h"

namespace phiz {
namespace {

constexpr int kMaxLevel = 8;

}  // namespace

TriangleMesh evaluate_head(const std::string& asset_bytes, const HeadSurfaceOptions& options) {
  std::istringstream in(asset_bytes);
  const HeadAsset asset = read_head_asset(in);
  const int finest = static_cast<int>(asset.displacements_mm.size()) - 1;
  const int level = options.level.value_or(std::max(0, finest));
  if (level < 0 || level > kMaxLevel)
    throw UsageError("--level " + std::to_string(level) + " is not from 0 to 8");

  std::vector<Eigen::Vector3d> control;
  for (const Eigen::Vector3f& position : asset.positions) control.push_back(position.cast<double>());
  std::vector<Eigen::Vector2d> control_uv;
  for (const Eigen::Vector2f& uv : asset.uv) control_uv.push_back(uv.cast<double>());
  const SubdivisionHierarchy hierarchy(asset.triangles, static_cast<int>(control.size()), level);
  std::vector<Eigen::Vector3d> positions =
      evaluate_surface(hierarchy, control, asset.displacements_mm, level);
  if (options.in_scan_frame) {
    Eigen::Affine3d scan_from_head;
    scan_from_head.matrix() = asset.scan_from_head;
    for (Eigen::Vector3d& position : positions) position = scan_from_head * position;
  }
  const std::vector<Eigen::Vector3d> normals = compute_vertex_normals(positions, hierarchy.triangles(level));

  TriangleMesh mesh;
  mesh.triangles = hierarchy.triangles(level);
  for (const Eigen::Vector3d& position : positions) mesh.positions.push_back(position.cast<float>());
  for (const Eigen::Vector3d& normal : normals) mesh.normals.push_back(normal.cast<float>());
  for (const Eigen::Vector2d& uv : evaluate_uv(hierarchy, control_uv, level))
    mesh.uv.push_back(uv.cast<float>());
  return mesh;
}

Image draw_head(const TriangleMesh& mesh) {
  std::vector<Image> views;
  std::vector<std::string> labels = {"front", "threequarter", "side", "back"};
  for (const std::string& label : labels) {
    ViewOptions options;
    options.camera = find_camera(label).value();
    views.push_back(render_mesh(mesh, options));
  }
  return contact_sheet({views}, {labels});
}

}  // namespace phiz
