#include "orchestrator/tasks/adapt.h"

#include <algorithm>
#include <utility>

#include "stages/deform/deform.h"
#include "stages/geometry/error.h"
#include "stages/geometry/normals.h"
#include "stages/publish/views.h"

namespace phiz {
namespace {

constexpr double kDetailShare = 0.05;                      ///< of the tolerance: what points may leave out
constexpr double kLeastDetail = 0.02, kMostDetail = 0.25;  ///< mm
constexpr float kSquareSide = 200.0f;                      ///< of the (u,v) square in pictures, mm

std::vector<Eigen::Vector3f> to_float(const std::vector<Eigen::Vector3d>& values) {
  std::vector<Eigen::Vector3f> made;
  made.reserve(values.size());
  for (const Eigen::Vector3d& value : values) made.push_back(value.cast<float>());
  return made;
}

AdaptedHead describe(const AdaptiveMesh& mesh, const AdaptReport& report) {
  AdaptedHead head;
  head.report = report;
  head.mesh = mesh.to_triangle_mesh();
  head.uv_mesh.triangles = head.mesh.triangles;
  for (const Eigen::Vector2f& uv : head.mesh.uv)
    head.uv_mesh.positions.emplace_back(kSquareSide * uv.x(), kSquareSide * uv.y(), 0.0f);
  return head;
}

}  // namespace

HeadAdapter::HeadAdapter(const ControlMesh& generic_head, const HeadAsset& head, const BaseLayout* layout,
                         const AdaptRequest& request)
    : generic_head_(generic_head), head_(head), request_(request) {
  level_ = request.level.value_or(std::max(0, static_cast<int>(head.displacements_mm.size()) - 1));
  chart_ = std::make_unique<UvChart>(make_uv_chart(generic_head.uv, head.triangles, level_));
  for (const Eigen::Vector3f& p : head.positions) control_.push_back(p.cast<double>());
  const auto surface = evaluate_surface(chart_->hierarchy, control_, head.displacements_mm, level_);
  normals_ = to_float(compute_vertex_normals(surface, chart_->hierarchy.triangles(level_)));
  positions_ = to_float(surface);
  std::vector<Eigen::Vector3i> triangles = head.triangles;
  std::vector<Eigen::Vector2d> uv = generic_head.uv;
  if (layout != nullptr) {
    triangles = triangulate_layout(*layout);
    uv = layout->uv;
  }
  given_vertices_ = static_cast<int>(uv.size());
  given_triangles_ = static_cast<int>(triangles.size());
  LevelSampler sampler(*chart_, positions_, normals_);
  std::vector<Eigen::Vector3d> places;
  for (const Eigen::Vector2d& place : uv) places.push_back(sampler.sample(0, place).position.cast<double>());
  base_ = make_base(uv, triangles, places, request.blocks);
}

HeadAdapter::~HeadAdapter() = default;

void HeadAdapter::weigh_by_confidence() {
  if (head_.confidences.empty() || head_.confidences.back().size() != positions_.size())
    throw InvalidInput("the head has no confidence at level " + std::to_string(level_));
  importance_ = importance_of_confidence(head_.confidences.back());
}

void HeadAdapter::weigh_by_texture(const PointCloud& cloud) {
  importance_ = importance_of_texture(*chart_, positions_, cloud);
}

void HeadAdapter::pose(const Deformation& rig, std::span<const float> parameters) {
  const NeutralMaker maker(generic_head_, level_);
  const NeutralSurface neutral = maker.make(control_, head_.displacements_mm);
  const CompiledCascade cascade(rig, sample_fields(rig, neutral.uv), neutral);
  cascade.evaluate(parameters, positions_);
  normals_ = compute_vertex_normals(positions_, chart_->hierarchy.triangles(level_));
}

SurfacePoints HeadAdapter::make_points() const {
  const bool is_in_mm =
      !request_.criterion.view && request_.criterion.norm != ContourNorm::kIntegral && !request_.in_order;
  const double detail =
      is_in_mm ? std::clamp(kDetailShare * request_.criterion.tolerance, kLeastDetail, kMostDetail)
               : kLeastDetail;
  SurfacePoints points = select_surface_points(*chart_, positions_, detail);
  if (!importance_.empty()) {
    for (const int v : points.vertices) points.importance.push_back(importance_[v]);
  }
  return points;
}

AdaptedHead HeadAdapter::run(const CriterionOptions& options, bool in_order) const {
  const SurfacePoints points = make_points();
  LevelSampler sampler(*chart_, positions_, normals_);
  CriterionSurface surface(base_.polyhedron, sampler, points, options);
  AdaptiveMesh mesh(surface);
  mesh.set_recording(false);
  AdaptBudget budget = request_.budget;
  if (in_order) budget.error = options.tolerance;
  const AdaptReport report = in_order ? mesh.refine_in_order(budget) : mesh.refine(budget);
  return describe(mesh, report);
}

AdaptedHead HeadAdapter::animate(const Deformation& rig, std::size_t frames,
                                 const std::function<std::span<const float>(std::size_t)>& parameters,
                                 const std::function<void(const AdaptedFrame&)>& tell) {
  if (request_.criterion.criterion == Criterion::kNormals)
    throw InvalidInput("normals are not followed over an animation", "use --criterion contour");
  const NeutralMaker maker(generic_head_, level_);
  SurfacePoints points = make_points();
  PosedSurface posed(rig, *chart_, maker.make(control_, head_.displacements_mm), points);
  CriterionSurface surface(base_.polyhedron, posed, points, request_.criterion);
  AdaptiveMesh mesh(surface);
  AdaptReport total;
  for (std::size_t frame = 0; frame < frames; ++frame) {
    posed.set_pose(parameters(frame));
    mesh.resample();
    mesh.clear_changes();
    const AdaptReport report = mesh.adapt(request_.budget);
    total.splits += report.splits;
    total.welds += report.welds;
    total.is_done = total.is_done && report.is_done;
    tell({frame, mesh.mesh().vertex_count(), mesh.mesh().face_count(), report.splits, report.welds, &mesh});
  }
  AdaptedHead last = describe(mesh, total);
  last.mesh.normals = compute_vertex_normals(last.mesh.positions, last.mesh.triangles);
  return last;
}

Image draw_adapted(const std::vector<AdaptedHead>& heads, const std::vector<std::string>& names) {
  std::vector<std::vector<Image>> rows;
  std::vector<std::vector<std::string>> labels;
  for (std::size_t i = 0; i < heads.size(); ++i) {
    ViewOptions options;
    options.width = 400;
    options.height = 430;
    options.wireframe = true;
    options.flat = true;
    std::vector<Image>& row = rows.emplace_back();
    row.push_back(render_mesh(heads[i].uv_mesh, options));
    options.camera.azimuth_deg = 25;
    row.push_back(render_mesh(heads[i].mesh, options));
    options.wireframe = options.flat = false;
    row.push_back(render_mesh(heads[i].mesh, options));
    labels.push_back({names[i] + ": " + std::to_string(heads[i].mesh.vertex_count()) + " vertices",
                      std::to_string(heads[i].mesh.triangle_count()) + " triangles", ""});
  }
  return contact_sheet(rows, labels);
}

}  // namespace phiz
