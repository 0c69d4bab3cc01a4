#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <fstream>
#include <limits>

#include "formats/geometry_image.h"
#include "formats/scan_file.h"
#include "stages/deform/learn.h"
#include "stages/deform/pca.h"
#include "stages/geometry/point_index.h"
#include "stages/geometry/surface_index.h"
#include "stages/unwrap/unwrap.h"
#include "tests/bench/fields.h"

namespace phiz::bench {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr double kMovesMm = 1, kStillMm = 0.02;
constexpr float kSeenMm = 1;
constexpr int kImageSide = 512, kPcaSide = 128;

// --- geometry images ---

void measure_images(const FieldsWorld& world) {
  const GenericHead& head = world.bench.head;
  const std::vector<bool> face = head.region_at("face", kFinestLevel);
  double worst_mean = 0, worst_max = 0;
  for (const BenchSubject& subject : world.bench.data.subjects) {
    if (subject.truth.empty()) continue;
    const std::filesystem::path file = world.bench.scratch / (subject.name + ".exr");
    const test::ProgramRun run = run_phiz(
        world.store, {"export", subject.name, "-o", file.string(), "--size", std::to_string(kImageSide)});
    if (run.exit_code != 0) throw std::runtime_error("phiz export: " + run.err);
    std::ifstream exr(file, std::ios::binary);
    const TriangleMesh grid = make_grid_mesh(read_geometry_image(exr));
    const SurfaceIndex index(grid.positions, grid.triangles);
    const FittedHead fitted = load_fitted(world.store, world.fits.subjects.at(subject.name), head);
    const std::vector<SurfaceHit> hits = index.find_nearest(to_float(evaluate_finest(fitted, head)), kFar);
    double sum = 0, count = 0, largest = 0;
    for (std::size_t i = 0; i < hits.size(); ++i) {
      if (!face[i]) continue;
      sum += hits[i].distance;
      largest = std::max(largest, hits[i].distance);
      ++count;
    }
    worst_mean = std::max(worst_mean, sum / count);
    worst_max = std::max(worst_max, largest);
  }
  world.bench.board.add(
      {"geometry image 512^2 to surface, face, mean, worst subject", worst_mean, "mm", at_most(0.03)});
  world.bench.board.add(
      {"geometry image 512^2 to surface, face, max, worst subject", worst_max, "mm", at_most(0.5)});
}

// --- learned fields ---

/// Expressions that were scanned on `source` and whose truth `target` has.
struct ExpressionSet {
  const BenchSubject* source = nullptr;
  const BenchSubject* target = nullptr;
  std::vector<std::string> names;
};

std::filesystem::path scan_of(const BenchData& data, const std::string& subject, const std::string& name) {
  return data.folder / "expressions" / (subject + "_" + name + ".ply");
}

std::filesystem::path truth_of(const BenchData& data, const std::string& subject, const std::string& name) {
  return data.folder / "truth" / (subject + "_" + name + ".ply");
}

ExpressionSet find_expressions(const BenchData& data) {
  std::vector<std::string> files;
  if (std::filesystem::is_directory(data.folder / "expressions"))
    for (const auto& entry : std::filesystem::directory_iterator(data.folder / "expressions"))
      files.push_back(entry.path().stem().string());
  std::sort(files.begin(), files.end());
  for (const BenchSubject& source : data.subjects) {
    for (const BenchSubject& target : data.subjects) {
      if (source.name == target.name) continue;
      ExpressionSet set{&source, &target, {}};
      for (const std::string& file : files) {
        if (!file.starts_with(source.name + "_")) continue;
        const std::string name = file.substr(source.name.size() + 1);
        if (std::filesystem::exists(truth_of(data, target.name, name))) set.names.push_back(name);
      }
      if (!set.names.empty()) return set;
    }
  }
  return {};
}

Positions load_positions(const std::filesystem::path& file) {
  const ScanFile mesh = read_scan_file(file);
  Positions positions;
  for (const Eigen::Vector3f& p : mesh.points.positions) positions.push_back(p.cast<double>() + mesh.origin);
  return positions;
}

/// The target: its true neutral skin, where that lies on the fitted surface, and what its scan saw.
struct Target {
  Positions truth;
  std::vector<SurfaceHit> hits;
  std::vector<bool> counts;
  Eigen::Matrix3d truth_from_head;  ///< turn and scale alone
};

Target make_target(const FieldsWorld& world, const BenchSubject& subject, const NeutralSurface& neutral,
                   const std::vector<Eigen::Vector3i>& triangles) {
  const FittedHead fitted = load_fitted(world.store, world.fits.subjects.at(subject.name), world.bench.head);
  const Eigen::Matrix4d truth_from_head = subject.scan_from_truth.inverse() * fitted.scan_from_head;
  Target target;
  target.truth_from_head = truth_from_head.topLeftCorner<3, 3>();
  const TriangleMesh truth = load_truth(subject);
  for (const Eigen::Vector3f& p : truth.positions) target.truth.push_back(p.cast<double>());
  const SurfaceIndex index(to_float(transform(truth_from_head, neutral.positions)), triangles);
  target.hits = index.find_nearest(truth.positions, kFar);
  std::vector<bool> is_skin(truth.positions.size(), false);
  for (int t = 0; t < world.bench.data.labels.skin_triangles; ++t)
    for (const int corner : truth.triangles[t]) is_skin[corner] = true;
  const PointIndex seen(to_float(transform(truth_from_head, fitted.cloud.positions)));
  for (std::size_t i = 0; i < truth.positions.size(); ++i)
    target.counts.push_back(is_skin[i] && seen.find_nearest(truth.positions[i], kSeenMm).point_idx >= 0);
  return target;
}

struct MotionError {
  double share_percent = 0, motion_mm = 0, still_mm = 0;
};

MotionError compare(const Target& target, const Positions& expression, const Positions& moved,
                    const std::vector<Eigen::Vector3i>& triangles) {
  double error = 0, motion = 0, still = 0, still_count = 0, count = 0;
  for (std::size_t i = 0; i < target.truth.size(); ++i) {
    if (!target.counts[i]) continue;
    const Eigen::Vector3d truth = expression[i] - target.truth[i];
    const SurfaceHit& hit = target.hits[i];
    Eigen::Vector3d got = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) got += hit.weights[k] * moved[triangles[hit.triangle_idx][k]];
    got = target.truth_from_head * got;
    if (truth.norm() >= kMovesMm) {
      error += (got - truth).norm();
      motion += truth.norm();
      ++count;
    } else if (truth.norm() <= kStillMm) {
      still += got.norm();
      ++still_count;
    }
  }
  return {100 * error / motion, motion / count, still / std::max(1.0, still_count)};
}

void measure_learned(const FieldsWorld& world) {
  const BenchData& data = world.bench.data;
  const ExpressionSet set = find_expressions(data);
  if (set.names.empty()) {
    world.bench.board.note("no expression scans whose truth another subject has: learned fields skipped");
    return;
  }
  const std::filesystem::path rig_path = world.bench.scratch / "learned";
  std::vector<std::string> words = {"fields", "learn",           "--neutral", set.source->name,
                                    "-o",     rig_path.string(), "--muscles", world.rig_path.string()};
  std::vector<std::string> names;
  for (const std::string& name : set.names) {
    if (name == "neutral") continue;
    names.push_back(name);
    words.insert(words.end(), {"--expression", name + "=" + scan_of(data, set.source->name, name).string()});
  }
  const test::ProgramRun run = run_phiz(world.store, words);
  if (run.exit_code != 0) throw std::runtime_error("phiz fields learn: " + run.err);
  std::ifstream json(rig_path.string() + ".json"), exr(rig_path.string() + ".exr", std::ios::binary);
  const Deformation rig = read_deformation(json, exr);

  const NeutralMaker maker(world.bench.head.mesh, kFinestLevel);
  const std::vector<Eigen::Vector3i>& triangles = maker.hierarchy().triangles(kFinestLevel);
  const NeutralSurface neutral = load_neutral(world, set.target->name, maker);
  const CompiledCascade cascade(rig, sample_fields(rig, neutral.uv), neutral);
  const Target target = make_target(world, *set.target, neutral, triangles);
  world.bench.board.note(fmt::format("learned on {}, on {}: truth's skin that the scan saw", set.source->name,
                                     set.target->name));
  for (const std::string& name : names) {
    std::vector<float> parameters(rig.parameters.size(), 0.0f);
    for (std::size_t k = 0; k < parameters.size(); ++k) parameters[k] = rig.parameters[k].name == name;
    std::vector<Eigen::Vector3f> at(neutral.positions.size());
    cascade.evaluate(parameters, at);
    Positions moved(at.size());
    for (std::size_t i = 0; i < at.size(); ++i) moved[i] = (at[i] - neutral.positions[i]).cast<double>();
    const MotionError error =
        compare(target, load_positions(truth_of(data, set.target->name, name)), moved, triangles);
    world.bench.board.add(
        {fmt::format("learned {}: error over what moves, of {:.2f} mm", name, error.motion_mm),
         error.share_percent, "%", at_most(15)});
    world.bench.board.add(
        {fmt::format("learned {}: what stays still moves, mean", name), error.still_mm, "mm", at_most(0.2)});
  }
}

// --- PCA ---

struct Shapes {
  std::vector<std::vector<float>> vectors;  ///< aligned to the generic head
  std::vector<float> weights;               ///< area on the face, next to nothing elsewhere
};

Shapes load_shapes(const FieldsWorld& world) {
  const GenericHead& head = world.bench.head;
  const UvChart chart = make_uv_chart(head.mesh.uv, head.mesh.triangles, kFinestLevel);
  const std::vector<bool> face = head.region_at("face", kFinestLevel);
  std::vector<std::uint8_t> on_face;
  for (const bool is_face : face) on_face.push_back(is_face ? 255 : 0);
  const UvSurface generic(chart, evaluate_surface(chart.hierarchy, head.mesh.positions, {}, kFinestLevel));
  Shapes shapes;
  const double step = 1.0 / (kPcaSide - 1);
  for (int i = 0; i < kPcaSide * kPcaSide; ++i) {
    const Eigen::Vector2d uv((i % kPcaSide) * step, 1 - (i / kPcaSide) * step);
    const UvSample there = generic.evaluate(uv);
    const double area = there.du.cross(there.dv).norm() * step * step;
    const bool counts = generic.interpolate(on_face, uv) > 127;
    shapes.weights.insert(shapes.weights.end(), 3, static_cast<float>(area * (counts ? 1 : 1e-6) + 1e-12));
  }
  for (const BenchSubject& subject : world.bench.data.subjects) {
    if (subject.truth.empty()) continue;
    const FittedHead fitted = load_fitted(world.store, world.fits.subjects.at(subject.name), head);
    const Eigen::Isometry3d motion = find_rigid_alignment(fitted.control, head.mesh.positions);
    const UvSurface surface(chart, evaluate_finest(fitted, head));
    std::vector<float>& vector = shapes.vectors.emplace_back();
    for (int i = 0; i < kPcaSide * kPcaSide; ++i) {
      const Eigen::Vector3d p =
          motion * surface.position_at({(i % kPcaSide) * step, 1 - (i / kPcaSide) * step});
      for (const double value : p) vector.push_back(static_cast<float>(value));
    }
  }
  return shapes;
}

double face_error(const Shapes& shapes, const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0, area = 0;
  for (std::size_t i = 0; i < a.size(); i += 3) {
    const Eigen::Vector3d d(a[i] - b[i], a[i + 1] - b[i + 1], a[i + 2] - b[i + 2]);
    sum += shapes.weights[i] * d.norm();
    area += shapes.weights[i];
  }
  return sum / area;
}

void measure_pca(const FieldsWorld& world) {
  const Shapes shapes = load_shapes(world);
  const std::size_t count = shapes.vectors.size();
  if (count < 3) return;
  std::vector<double> errors(count - 1, 0.0);  // by number of components, mean over who is left out
  double reproduced = 0;
  for (std::size_t left_out = 0; left_out < count; ++left_out) {
    StreamingPca pca(shapes.weights, static_cast<int>(count));
    for (std::size_t s = 0; s < count; ++s)
      if (s != left_out) pca.add(shapes.vectors[s]);
    pca.finish();
    const ShapeModel model = make_shape_model(pca);
    const std::vector<double> all = project(model, shapes.vectors[left_out]);
    for (std::size_t k = 0; k < errors.size(); ++k) {
      const std::size_t used = std::min(k, all.size());
      errors[k] +=
          face_error(shapes, synthesise(model, std::span(all).first(used)), shapes.vectors[left_out]) /
          static_cast<double>(count);
    }
    for (std::size_t s = 0; s < count; ++s)
      if (s != left_out)
        reproduced = std::max(
            reproduced,
            face_error(shapes, synthesise(model, project(model, shapes.vectors[s])), shapes.vectors[s]));
  }
  std::string line = "leave one out, face, mean error in mm by components:";
  bool falls = true;
  for (std::size_t k = 0; k < errors.size(); ++k) {
    line += fmt::format(" {}: {:.3f}", k, errors[k]);
    if (k > 0 && errors[k] >= errors[k - 1]) falls = false;
  }
  world.bench.board.note(line);
  world.bench.board.add(
      {fmt::format("PCA of {}, the one left out, face", count - 1), errors.back(), "mm", {}});
  world.bench.board.add(
      {"PCA: error falls with every component (1: yes)", falls ? 1.0 : 0.0, "", at_least(1)});
  world.bench.board.add({fmt::format("PCA: the {} reproduced with all components, worst", count - 1),
                         reproduced, "mm", at_most(0.05)});
}

}  // namespace

void measure_learned_fields(const FieldsWorld& world) {
  measure_images(world);
  measure_learned(world);
  measure_pca(world);
}

}  // namespace phiz::bench
