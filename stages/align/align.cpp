#include "stages/align/align.h"

#include <Eigen/Geometry>
#include <cmath>

#include "stages/align/mesh_silhouette.h"
#include "stages/align/point_silhouette.h"
#include "stages/geometry/annotations.h"
#include "stages/geometry/error.h"
#include "stages/geometry/point_grid.h"
#include "stages/geometry/powell.h"

namespace phiz {
namespace {

constexpr int kParameters = 9;  ///< rotation vector, shift in mm, log scales

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& omega) {
  const double angle = omega.norm();
  return angle < 1e-12 ? Eigen::Matrix3d::Identity()
                       : Eigen::AngleAxisd(angle, omega / angle).toRotationMatrix();
}

AffineMatrix affine_of(const Eigen::VectorXd& q, double head_scale, const Eigen::Vector3d& pivot_model) {
  AffineMatrix m;
  const Eigen::Vector3d scales = head_scale * q.segment<3>(6).array().exp();
  m.leftCols<3>() = rotation_of(q.head<3>()) * scales.asDiagonal();
  // Turning and scaling about the middle of the head keeps the parameters apart from the shift.
  m.col(3) = head_scale * pivot_model + q.segment<3>(3) - m.leftCols<3>() * pivot_model;
  return m;
}

Eigen::AlignedBox3d box_of(const ControlMesh& head) {
  Eigen::AlignedBox3d box;
  for (const auto& p : head.positions) box.extend(p);
  return box;
}

/// Whether the scan has next to nothing where the back of the generic head is.
bool lacks_back(const PointCloud& cloud, const ControlMesh& head, double head_scale, const Plane& back) {
  const PointGrid grid(cloud.positions, 8.0f);
  int behind = 0, seen = 0;
  for (const auto& p : head.positions) {
    if (back.normal.dot(p) >= back.offset_mm) continue;
    ++behind;
    bool near = false;
    grid.for_each_within((head_scale * p).cast<float>(), 16.0f, [&](int, float) { near = true; });
    seen += near;
  }
  return behind > 0 && seen < behind / 2;
}

/// Squared departure from the starting pose in units of 3 degrees, 8 mm and 6 % of stretch.
double departure(const Eigen::VectorXd& q) {
  const Eigen::Array3d log_scales = q.segment<3>(6).array();
  const double mean = log_scales.mean();
  return (q.head<3>() / 0.0524).squaredNorm() + (q.segment<3>(3) / 8.0).squaredNorm() +
         ((log_scales - mean) / 0.06).matrix().squaredNorm() + std::pow(mean / 0.06, 2);
}

class SilhouetteSearch {
 public:
  SilhouetteSearch(const PointCloud& cloud, const ControlMesh& head, double head_scale, bool clip_back,
                   int size)
      : mesh_(floats(head.positions), head.triangles),
        head_scale_(head_scale),
        pivot_(box_of(head).center()) {
    Eigen::AlignedBox3d box;
    for (const auto& p : cloud.positions) box.extend(p.cast<double>());
    const Eigen::AlignedBox3d model = box_of(head);
    box.extend(head_scale * model.min());
    box.extend(head_scale * model.max());
    frame_ = make_silhouette_frame(box, size);
    const AffineMatrix as_it_is = AffineMatrix::Identity();
    point_size_ = find_point_size(cloud.positions, as_it_is, frame_).pixels;
    for (const ViewAxis axis : kViewAxes) {
      rasterise_points(cloud.positions, as_it_is, axis, frame_, {.size_px = point_size_, .shrink_back = true},
                       cloud_[static_cast<int>(axis)]);
      auto& mask = masks_[static_cast<int>(axis)];
      const Plane& neck = head.annotations.clipping_planes.at("neck");
      mask = make_half_plane_mask(neck.normal, head_scale * neck.offset_mm, axis, frame_);
      if (!clip_back) continue;
      const Plane& back = head.annotations.clipping_planes.at("back");
      intersect(mask, make_half_plane_mask(back.normal, head_scale * back.offset_mm, axis, frame_));
    }
  }

  std::int64_t white_pixels(const Eigen::VectorXd& q) {
    const AffineMatrix m = affine_of(q, head_scale_, pivot_);
    std::int64_t white = 0;
    for (const ViewAxis axis : kViewAxes) {
      const int v = static_cast<int>(axis);
      rasteriser_.rasterise(mesh_, m, axis, frame_, model_[v]);
      white += count_xor(cloud_[v], model_[v], masks_[v]);
    }
    return white;
  }

  PowellResult minimise(const Eigen::VectorXd& start, double step_share, const AlignOptions& options) {
    PowellOptions powell;
    powell.initial_steps.resize(kParameters);
    powell.initial_steps << 0.06, 0.06, 0.06, 4, 4, 4, 0.04, 0.04, 0.04;
    powell.initial_steps *= step_share;
    powell.relative_tolerance = options.relative_tolerance;
    powell.max_evaluations = options.max_evaluations;
    std::int64_t covered = 0;
    for (const Silhouette& s : cloud_) covered += count_pixels(s);
    const double weight = options.pose_weight * static_cast<double>(covered);
    return minimise_powell(
        [&](const Eigen::VectorXd& q) {
          return static_cast<double>(white_pixels(q)) + weight * departure(q);
        },
        start, powell);
  }

  AffineMatrix affine(const Eigen::VectorXd& q) const { return affine_of(q, head_scale_, pivot_); }
  const SilhouetteFrame& frame() const { return frame_; }
  const std::array<Silhouette, 3>& cloud() const { return cloud_; }
  const std::array<Silhouette, 3>& model() const { return model_; }
  int point_size() const { return point_size_; }

 private:
  static std::vector<Eigen::Vector3f> floats(const std::vector<Eigen::Vector3d>& positions) {
    std::vector<Eigen::Vector3f> result;
    for (const auto& p : positions) result.push_back(p.cast<float>());
    return result;
  }

  SilhouetteMesh mesh_;
  SilhouetteRasteriser rasteriser_;
  double head_scale_;
  Eigen::Vector3d pivot_;
  SilhouetteFrame frame_;
  int point_size_ = 1;
  std::array<Silhouette, 3> cloud_, model_, masks_;
};

}  // namespace

AlignResult align(const PointCloud& cloud, const ControlMesh& generic_head, double head_scale,
                  const AlignOptions& options) {
  CONTRACT(head_scale > 0);
  require_annotations(generic_head);
  const auto& planes = generic_head.annotations.clipping_planes;
  AlignResult result;
  result.clipped_back =
      options.clip_back.value_or(lacks_back(cloud, generic_head, head_scale, planes.at("back")));

  SilhouetteSearch coarse(cloud, generic_head, head_scale, result.clipped_back, options.coarse_size);
  const PowellResult first = coarse.minimise(Eigen::VectorXd::Zero(kParameters), 1.0, options);
  SilhouetteSearch fine(cloud, generic_head, head_scale, result.clipped_back, options.fine_size);
  const PowellResult second = fine.minimise(first.parameters, 0.25, options);

  result.white_pixels_before = fine.white_pixels(Eigen::VectorXd::Zero(kParameters));
  result.white_pixels_after = fine.white_pixels(second.parameters);
  result.evaluations = first.evaluations + second.evaluations;
  result.head_from_model.topRows<3>() = fine.affine(second.parameters);
  result.scales = head_scale * second.parameters.segment<3>(6).array().exp();
  result.frame = fine.frame();
  result.cloud_silhouettes = fine.cloud();
  result.model_silhouettes = fine.model();
  result.point_size_px = fine.point_size();
  for (const Silhouette& s : result.cloud_silhouettes) result.covered_pixels += count_pixels(s);
  return result;
}

}  // namespace phiz
