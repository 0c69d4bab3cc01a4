#include <fmt/format.h>

#include <cmath>
#include <fstream>

#include "tests/bench/adapt.h"

namespace phiz::bench {
namespace {

constexpr int kFrames = 300, kCheckBothWaysEvery = 10;
constexpr double kTolerance = 2.0;  ///< mm
constexpr double kShare = 0.95;     ///< of it that the criterion may use: it does not look at every vertex

Deformation make_rig(const AdaptWorld& world) {
  const std::filesystem::path path = world.bench.scratch / "adapt_rig";
  const test::ProgramRun made =
      run_phiz(world.store,
               {"fields", "muscles", "--from", PHIZ_SOURCE_FOLDER "/samples/muscles", "-o", path.string()});
  if (made.exit_code != 0) throw std::runtime_error("phiz fields muscles: " + made.err);
  std::ifstream json(path.string() + ".json"), exr(path.string() + ".exr", std::ios::binary);
  return read_deformation(json, exr);
}

/// Every control on a curve of its own, up to 0.8, ten seconds at 30 frames a second.
std::vector<float> pose_at(const Deformation& rig, int frame) {
  std::vector<float> controls;
  for (std::size_t k = 0; k < rig.controls.size(); ++k) {
    const double phase = 2 * M_PI * (frame / 30.0) * (0.13 + 0.021 * static_cast<double>(k % 11));
    const double wave = std::sin(phase + 0.7 * static_cast<double>(k));
    controls.push_back(static_cast<float>(wave > 0.4 ? (wave - 0.4) / 0.6 * 0.8 : 0.0));
  }
  return parameters_of_controls(rig, controls);
}

}  // namespace

void measure_clip(const AdaptWorld& world) {
  Board& board = world.bench.board;
  AdaptSubject subject = load_adapt_subject(world, list_adapt_subjects(world).at(0));
  const Deformation rig = make_rig(world);
  const NeutralMaker maker(world.bench.head.mesh, kFinestLevel);
  const NeutralSurface neutral = maker.make(subject.control, subject.displacements_mm);
  const CompiledCascade everything(rig, sample_fields(rig, neutral.uv), neutral);
  PosedSurface posed(rig, world.chart, neutral, subject.points);
  CriterionOptions options;
  options.tolerance = kShare * kTolerance;
  CriterionSurface surface(subject.face_base.polyhedron, posed, subject.points, options, subject.base_faces);
  AdaptiveMesh mesh(surface);
  posed.set_pose(pose_at(rig, 0));
  mesh.resample();
  mesh.adapt();
  std::vector<double> times, errors, changes, vertices;
  double invalid = 0, back = 0;
  std::vector<Eigen::Vector3f> truth(neutral.positions.size());
  for (int frame = 0; frame < kFrames; ++frame) {
    const std::vector<float> parameters = pose_at(rig, frame);
    mesh.clear_changes();
    const double start = processor_seconds();
    posed.set_pose(parameters);
    mesh.resample();
    mesh.adapt();
    times.push_back(1e3 * (processor_seconds() - start));
    changes.push_back(static_cast<double>(mesh.changes().size()));
    vertices.push_back(mesh.mesh().vertex_count());
    invalid += !mesh.validate().empty();
    everything.evaluate(parameters, truth);
    const TriangleMesh made = mesh.to_triangle_mesh();
    const SurfaceIndex index(made.positions, made.triangles);
    double error = 0;
    for (const SurfaceHit& hit : index.find_nearest(truth, 1e6)) error = std::max(error, hit.distance);
    errors.push_back(error);
    if (frame % kCheckBothWaysEvery != 0) continue;
    const SurfaceIndex truth_index(truth, world.chart.hierarchy.triangles(kFinestLevel));
    back = std::max(back, measure_hausdorff(made, truth, truth_index).from_mesh_mm);
  }
  board.note(fmt::format(
      "{}: {} frames, tolerance {} mm, {:.0f} to {:.0f} vertices, {:.1f} operators a frame", subject.name,
      kFrames, kTolerance, quantile(vertices, 0), quantile(vertices, 1), mean(changes)));
  board.add({"a frame of a 300-frame clip, contour, incremental, mean", mean(times), "ms", at_most(2)});
  board.add({"the slowest frame", quantile(times, 1), "ms", {}});
  board.add({"largest distance of any level-4 vertex to the mesh, over the tolerance, worst frame",
             quantile(errors, 1) / kTolerance, "x", at_most(1)});
  board.add({"largest distance of the mesh to level 4, over the tolerance, every tenth frame",
             back / kTolerance,
             "x",
             {}});
  board.add({"frames with a crack or another broken invariant", invalid, "", at_most(0)});
}

}  // namespace phiz::bench
