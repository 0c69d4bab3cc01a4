#include "stages/ingest/ingest.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "stages/geometry/error.h"
#include "stages/geometry/normals.h"
#include "stages/geometry/point_grid.h"
#include "stages/ingest/clean.h"
#include "stages/ingest/field.h"
#include "stages/ingest/orient.h"
#include "stages/ingest/pose_polish.h"
#include "stages/ingest/pose_search.h"
#include "stages/ingest/soup.h"

namespace phiz {
namespace {

PointCloud gather_points(const ScanFile& scan, const IngestOptions& options, IngestSummary& summary) {
  summary.points_read = scan.points.size();
  PointCloud cloud;
  if (!scan.triangles.empty()) {
    cloud = sample_soup(scan, options.soup_samples);
  } else {
    cloud = scan.points;
    cloud.normals.clear();  // of unknown origin; estimated anew
    cloud.confidences.clear();
    if (options.max_points > 0 && cloud.size() > static_cast<std::size_t>(options.max_points)) {
      std::vector<char> keep(cloud.size(), 0);
      const std::size_t target = options.max_points;
      for (std::size_t i = 0; i < target; ++i) keep[i * cloud.size() / target] = 1;
      keep_points(cloud, keep);
    }
  }
  std::vector<char> keep(cloud.size());
  constexpr float kBeyondMeasure = 1e15f;  // squares of it are still numbers
  for (std::size_t i = 0; i < keep.size(); ++i)
    keep[i] = (cloud.positions[i].array().abs() < kBeyondMeasure).all();
  summary.removed_non_finite = keep_points(cloud, keep);
  summary.points_sampled = cloud.size();
  if (cloud.size() < 1000)
    throw InvalidInput("only " + std::to_string(cloud.size()) + " usable points; a head needs at least 1000");
  return cloud;
}

/// Box that holds the middle 98 % along each axis, widened by half: gross outliers lie outside.
Eigen::AlignedBox3f robust_box(const std::vector<Eigen::Vector3f>& points) {
  Eigen::AlignedBox3f box;
  Eigen::Vector3f low, high;
  std::vector<float> values(points.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(points.begin(), points.end(), values.begin(), [&](const auto& p) { return p[axis]; });
    const std::size_t n = values.size() / 100;
    std::nth_element(values.begin(), values.begin() + n, values.end());
    low[axis] = values[n];
    std::nth_element(values.begin(), values.end() - 1 - n, values.end());
    high[axis] = *(values.end() - 1 - n);
  }
  const Eigen::Vector3f pad = Eigen::Vector3f::Constant(0.5f * (high - low).maxCoeff());
  return {low - pad, high + pad};
}

/// The points without gross outliers, which would make the lattices of the pose search coarse.
struct Inliers {
  std::vector<Eigen::Vector3f> points;
  float extent = 0;  ///< diagonal of the robust box
};

Inliers find_inliers(const std::vector<Eigen::Vector3f>& points) {
  const auto box = robust_box(points);
  Inliers inliers{{}, box.diagonal().norm()};
  if (!(inliers.extent > 0)) throw InvalidInput("all points of the scan are at one place");
  for (const auto& p : points)
    if (box.contains(p)) inliers.points.push_back(p);
  return inliers;
}

/// Evenly thinned samples for the pose search: mean points of the lattice cells that hold enough.
std::vector<Eigen::Vector3f> thin_scan(const Inliers& inliers) {
  const PointGrid grid(inliers.points, inliers.extent / 120.0f);
  const auto supported = find_supported(inliers.points, grid.cell());
  std::vector<Eigen::Vector3f> thinned;
  for (std::size_t c = 0; c < grid.cell_count(); ++c) {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    int count = 0;
    for (int slot = grid.cell_begin(c); slot < grid.cell_end(c); ++slot)
      if (supported[grid.order()[slot]]) sum += grid.sorted_points()[slot], ++count;
    if (count > 0) thinned.push_back(sum / float(count));
  }
  constexpr std::size_t kMost = 2500;
  std::vector<Eigen::Vector3f> samples;
  for (std::size_t i = 0; i < std::min(kMost, thinned.size()); ++i)
    samples.push_back(thinned[i * thinned.size() / std::min(kMost, thinned.size())]);
  return samples;
}

struct Unit {
  const char* name;
  double mm;
};
constexpr std::array<Unit, 4> kUnits{{{"mm", 1}, {"cm", 10}, {"in", 25.4}, {"m", 1000}}};

/// The unit in which the head is nearest to the generic head's size; none of them fits: taken to be of that
/// size.
void find_unit(double scan_units_per_mm, const IngestOptions& options, IngestSummary& summary) {
  if (options.mm_per_unit) {
    summary.unit = "stated";
    summary.mm_per_unit = *options.mm_per_unit;
    return;
  }
  const Unit* best = nullptr;
  double best_error = std::log(1.55);
  for (const Unit& unit : kUnits) {
    const double error = std::abs(std::log(scan_units_per_mm * unit.mm));
    if (error < best_error) best = &unit, best_error = error;
  }
  summary.unit = best ? best->name : "unknown";
  summary.mm_per_unit = best ? best->mm : 1.0 / scan_units_per_mm;
}

Plane scaled_neck(const ControlMesh& head, double scale, double margin_mm) {
  Plane plane = head.annotations.clipping_planes.at("neck");
  plane.offset_mm = plane.offset_mm * scale - margin_mm;
  return plane;
}

/// Share of the generic head's outer vertices with a scan point near them.
double compute_coverage(const PointCloud& cloud, const ControlMesh& head, double scale) {
  const PointGrid grid(cloud.positions, 6.0f);
  int seen = 0;
  for (const auto& p : head.positions) {
    bool near = false;
    grid.for_each_within((scale * p).cast<float>(), 12.0f, [&](int, float) { near = true; });
    seen += near;
  }
  return double(seen) / head.positions.size();
}

void remove_unwanted(PointCloud& cloud, const ControlMesh& head, float spacing_mm,
                     const IngestOptions& options, IngestSummary& summary) {
  const float radius = std::max(4.5f, 2.5f * spacing_mm);
  Eigen::AlignedBox3f head_box;
  for (const auto& p : head.positions) head_box.extend((summary.head_scale * p).cast<float>());
  const float reach = 0.35f * head_box.sizes().maxCoeff();  // hair, a crown, a collar
  const Plane neck = scaled_neck(head, summary.head_scale, options.neck_margin_mm);

  std::vector<char> keep(cloud.size());
  for (std::size_t i = 0; i < keep.size(); ++i)
    keep[i] = head_box.exteriorDistance(cloud.positions[i]) <= reach;
  summary.removed_far = keep_points(cloud, keep);
  if (!cloud.positions.empty())
    summary.removed_outliers = keep_points(cloud, find_supported(cloud.positions, radius));
  keep.resize(cloud.size());
  for (std::size_t i = 0; i < keep.size(); ++i)
    keep[i] = neck.normal.dot(cloud.positions[i].cast<double>()) >= neck.offset_mm;
  summary.removed_below_neck = keep_points(cloud, keep);
  if (cloud.size() < 1000) throw InvalidInput("fewer than 1000 points belong to the head");
}

OrientationGuide make_guide(const ControlMesh& head, double scale) {
  OrientationGuide guide;
  for (const auto& n : compute_vertex_normals(head.positions, head.triangles))
    guide.normals.push_back(n.cast<float>());
  for (const auto& p : head.positions) guide.positions.push_back((scale * p).cast<float>());
  return guide;
}

[[noreturn]] void reject(const IngestSummary& summary) {
  char text[120];
  std::snprintf(text, sizeof text,
                "no head was found in the scan (mismatch %.2f in place, %.2f with normals)",
                summary.pose_score, summary.pose_mismatch);
  throw FitRejected(text, "--set ingest.reject_score=1 --set ingest.reject_mismatch=1 tries all the same");
}

}  // namespace

IngestState place_head(const ScanFile& scan, const ControlMesh& generic_head, const IngestOptions& options) {
  IngestState state;
  IngestSummary& summary = state.summary;
  state.cloud = gather_points(scan, options, summary);

  const Inliers inliers = find_inliers(state.cloud.positions);
  auto poses = search_pose(thin_scan(inliers), generic_head);
  summary.pose_score = poses.front().score;
  poses.resize(std::min<std::size_t>(poses.size(), 3));
  const float spacing = median_spacing(state.cloud.positions);
  polish_poses(inliers.points, spacing, generic_head, poses);
  const SimilarityPose& pose = poses.front();
  summary.pose_mismatch = pose.score;
  if (summary.pose_score > options.reject_score || pose.score > options.reject_mismatch) reject(summary);
  find_unit(pose.scale, options, summary);
  summary.head_scale = state.head_scale = pose.scale * summary.mm_per_unit;
  summary.turned_deg = Eigen::AngleAxisd(pose.rotation).angle() * 180 / std::numbers::pi;

  state.scan_from_head.topLeftCorner<3, 3>() = pose.rotation / summary.mm_per_unit;
  state.scan_from_head.topRightCorner<3, 1>() = pose.translation + scan.origin;
  const Eigen::Matrix3d head_from_scan = pose.rotation.transpose() * summary.mm_per_unit;
  for (auto& p : state.cloud.positions)
    p = (head_from_scan * (p.cast<double>() - pose.translation)).cast<float>();

  state.spacing_mm = spacing * static_cast<float>(summary.mm_per_unit);
  remove_unwanted(state.cloud, generic_head, state.spacing_mm, options, summary);
  summary.points_kept = state.cloud.size();
  return state;
}

void orient_points(const ControlMesh& generic_head, IngestState& state) {
  const NormalEstimate estimate = estimate_normals(state.cloud, std::max(1.6f, 1.6f * state.spacing_mm),
                                                   make_guide(generic_head, state.head_scale));
  state.summary.noise_mm = estimate.noise_mm;
  state.summary.density_per_mm2 = estimate.density_per_mm2;
}

IngestResult finish_ingest(const ControlMesh& generic_head, const IngestOptions& options, IngestState state) {
  IngestResult result;
  result.cloud = std::move(state.cloud);
  result.scan_from_head = state.scan_from_head;
  result.head_scale = state.head_scale;
  result.summary = std::move(state.summary);
  result.summary.coverage = compute_coverage(result.cloud, generic_head, result.summary.head_scale);
  result.distance_field = compute_distance_field(result.cloud, options.field_voxel_mm);
  return result;
}

IngestResult ingest(const ScanFile& scan, const ControlMesh& generic_head, const IngestOptions& options) {
  IngestState state = place_head(scan, generic_head, options);
  orient_points(generic_head, state);
  return finish_ingest(generic_head, options, std::move(state));
}

}  // namespace phiz
