#include <fmt/format.h>

#include <algorithm>

#include "tests/bench/areas.h"
#include "tests/bench/correspondence.h"
#include "tests/bench/surface_error.h"

namespace phiz::bench {
namespace {

constexpr std::size_t kFewOutliers = 20;  // a share of fewer says nothing

/// One number a subject, by what it is.
struct Distances {
  std::vector<double> aligned, local, global, global_mesh, finest,
      truth;  ///< % of the clean cloud's box diagonal
  std::vector<double> kept_percent, dropped_percent;
  std::vector<double> skin, skin_medians;  ///< mm, of all subjects together
  std::vector<double> ratios;              ///< finest / truth of each subject
};

SurfaceIndex index_surface(const GenericHead& head, const Positions& control, int level) {
  return {to_float(evaluate_surface(head.hierarchy, control, {}, level)), head.hierarchy.triangles(level)};
}

void take_distances(const FittedHead& fitted, const GenericHead& head, const SurfaceIndex& finest,
                    Distances& distances) {
  const std::vector<Eigen::Vector3f>& points = fitted.cloud.positions;
  const double percent = 100 / box_diagonal(points);
  const auto add = [&](std::vector<double>& list, const SurfaceIndex& surface) {
    list.push_back(percent * mean_distance(points, surface));
  };
  add(distances.aligned, index_surface(head, fitted.aligned, kCorrespondenceLevel));
  add(distances.local, index_surface(head, fitted.local, kCorrespondenceLevel));
  add(distances.global, index_surface(head, fitted.control, kCorrespondenceLevel));
  add(distances.global_mesh, index_surface(head, fitted.control, 0));
  add(distances.finest, finest);
}

Placed take_subject(const BenchWorld& world, const BenchSubject& subject, const FittedHead& fitted,
                    Distances& distances) {
  const Positions finest = evaluate_finest(fitted, world.head);
  const std::vector<Eigen::Vector3i>& triangles = world.head.hierarchy.triangles(kFinestLevel);
  take_distances(fitted, world.head, SurfaceIndex(to_float(finest), triangles), distances);

  const TruthScene scene = load_truth_scene(subject);
  const Eigen::Matrix4d truth_from_head = subject.scan_from_truth.inverse() * fitted.scan_from_head;
  const std::vector<Eigen::Vector3f> cloud = to_float(transform(truth_from_head, fitted.cloud.positions));
  distances.truth.push_back(100 * mean_distance(cloud, scene.surface) / box_diagonal(fitted.cloud.positions));
  distances.ratios.push_back(distances.finest.back() / distances.truth.back());
  const IngestShares shares = measure_ingest(subject, scene, fitted, world.head);
  distances.kept_percent.push_back(100 * shares.kept_above_neck);
  if (shares.outliers >= kFewOutliers) distances.dropped_percent.push_back(100 * shares.dropped_outliers);

  Placed placed{subject.name, scene.truth, {}, transform(truth_from_head, finest)};
  placed.vertices.assign(placed.finest.begin(),
                         placed.finest.begin() + world.head.hierarchy.vertex_count(kCorrespondenceLevel));
  const SurfaceIndex surface(to_float(placed.finest), triangles);
  const SkinErrors skin = measure_skin(subject, scene, world.data.labels, fitted, world.head, surface);
  distances.skin.insert(distances.skin.end(), skin.surface.begin(), skin.surface.end());
  distances.skin_medians.insert(distances.skin_medians.end(), skin.point_medians.begin(),
                                skin.point_medians.end());
  world.board.note(fmt::format(
      "{}: align {:.3f} local {:.3f} global {:.3f} level 4 {:.4f} truth {:.4f} %, kept {:.2f} %, outliers "
      "dropped "
      "{:.1f} % of {}, skin {:.3f} / {:.3f} mm",
      subject.name, distances.aligned.back(), distances.local.back(), distances.global.back(),
      distances.finest.back(), distances.truth.back(), 100 * shares.kept_above_neck,
      100 * shares.dropped_outliers, shares.outliers, mean(skin.surface), quantile(skin.surface, 0.95)));
  return placed;
}

double least(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::min_element(values.begin(), values.end());
}

void report(Board& board, const Distances& distances) {
  board.add({"ingest: points above the neck that are kept, least of the subjects",
             least(distances.kept_percent), "%", at_least(97)});
  board.add({"ingest: outliers beyond 5 mm that are dropped, least of the subjects",
             least(distances.dropped_percent), "%", at_least(90)});
  board.add({"cloud to surface after align", mean(distances.aligned), "% diagonal", at_most(1.2)});
  board.add({"cloud to surface after local fit", mean(distances.local), "% diagonal", at_most(1.0)});
  board.add({"cloud to surface after global fit", mean(distances.global), "% diagonal", at_most(0.11)});
  board.add(
      {"the same to the flat triangles of the control mesh", mean(distances.global_mesh), "% diagonal", {}});
  board.add({"cloud to displaced level 4", mean(distances.finest), "% diagonal", {}});
  board.add({"cloud to the true surface", mean(distances.truth), "% diagonal", {}});
  board.add(
      {"level 4 over the true surface", mean(distances.finest) / mean(distances.truth), "x", at_most(1.05)});
  board.add({"the same, worst subject", quantile(distances.ratios, 1), "x", {}});
  board.add({"true skin to level 4, mean", mean(distances.skin), "mm", at_most(0.10)});
  board.add({"true skin to level 4, 95 %", quantile(distances.skin, 0.95), "mm", at_most(0.32)});
  board.add({"median of the points about it, mean", mean(distances.skin_medians), "mm", {}});
  board.add({"median of the points about it, 95 %", quantile(distances.skin_medians, 0.95), "mm", {}});
}

}  // namespace

void measure_accuracy(const BenchWorld& world, const std::filesystem::path& store, const FitRun& everything) {
  Distances distances;
  std::vector<Placed> placed;
  for (const BenchSubject& subject : world.data.subjects) {
    const auto run = everything.subjects.find(subject.name);
    if (subject.truth.empty() || run == everything.subjects.end() || !run->second.is_done) continue;
    placed.push_back(take_subject(world, subject, load_fitted(store, run->second, world.head), distances));
  }
  report(world.board, distances);
  const Correspondence error = measure_correspondence(placed, world.head, world.data.labels);
  world.board.note(fmt::format("{} ordered pairs, vertices of level {}", error.pairs, kCorrespondenceLevel));
  world.board.add({"same anatomy across subjects, narrow face", error.narrow_face, "mm", at_most(2.0)});
  world.board.add({"the same with mouth pocket and nostrils", error.narrow_face_all, "mm", {}});
}

}  // namespace phiz::bench
