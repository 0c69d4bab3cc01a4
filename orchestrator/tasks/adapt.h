#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/base_layout.h"
#include "formats/control_mesh.h"
#include "formats/deformation.h"
#include "formats/head_asset.h"
#include "formats/image.h"
#include "formats/point_cloud.h"
#include "stages/adapt/adapt.h"

namespace phiz {

struct AdaptRequest {
  CriterionOptions criterion;
  bool in_order = false;  ///< largest error first (kDistance), up to the budget
  AdaptBudget budget;
  BlockOrder blocks = BlockOrder::kMatching;
  std::optional<int> level;  ///< of the surface; absent: the head's finest
};

struct AdaptedHead {
  TriangleMesh mesh, uv_mesh;  ///< the same triangles in space and in the (u,v) square (200 mm a side)
  AdaptReport report;
};

/// What changed in one frame of an animation.
struct AdaptedFrame {
  std::size_t frame = 0;
  int vertices = 0, triangles = 0, splits = 0, welds = 0;
  const AdaptiveMesh* mesh = nullptr;  ///< its changes are those of the frame
};

/// A fitted head as a surface to adapt to, neutral or posed.
class HeadAdapter {
 public:
  /// `layout` null: the generic head's own triangles are the base. Throws FormatError and InvalidInput.
  HeadAdapter(const ControlMesh& generic_head, const HeadAsset& head, const BaseLayout* layout,
              const AdaptRequest& request);
  ~HeadAdapter();

  void weigh_by_confidence();
  void weigh_by_texture(const PointCloud& cloud);
  void pose(const Deformation& rig, std::span<const float> parameters);
  const CompliantMesh& base_report() const { return base_.report; }
  int given_vertices() const { return given_vertices_; }
  int given_triangles() const { return given_triangles_; }

  /// With another criterion than the request's where one is given.
  AdaptedHead run(const CriterionOptions& options, bool in_order) const;
  /// Frame after frame from the mesh of the one before; returns the last. `parameters(frame)` are the rig's.
  AdaptedHead animate(const Deformation& rig, std::size_t frames,
                      const std::function<std::span<const float>(std::size_t)>& parameters,
                      const std::function<void(const AdaptedFrame&)>& tell);

 private:
  SurfacePoints make_points() const;

  const ControlMesh& generic_head_;
  const HeadAsset& head_;
  AdaptRequest request_;
  int level_ = 0, given_vertices_ = 0, given_triangles_ = 0;
  std::unique_ptr<UvChart> chart_;
  std::vector<Eigen::Vector3d> control_;
  std::vector<Eigen::Vector3f> positions_, normals_;
  std::vector<float> importance_;
  MadeBase base_;
};

/// A row a mesh: (u,v) mesh, polygon mesh, shaded head (Goldenstein, Vogler, Velho 2005, figure 2).
Image draw_adapted(const std::vector<AdaptedHead>& heads, const std::vector<std::string>& names);

}  // namespace phiz
