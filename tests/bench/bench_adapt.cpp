#include <time.h>

#include <fstream>

#include "stages/geometry/normals.h"
#include "tests/bench/adapt.h"
#include "tests/bench/bench_main.h"

namespace phiz::bench {
namespace {

constexpr double kDetail = 0.05;  ///< mm: finest vertices that say less are not looked at by the criteria
constexpr int kSteps = 6;         ///< places along a triangle's edge when a mesh is sampled

}  // namespace

double processor_seconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

AdaptWorld make_adapt_world(const BenchWorld& bench) {
  AdaptWorld world{bench, bench.scratch / "adapt",
                   {},    make_uv_chart(bench.head.mesh.uv, bench.head.mesh.triangles, kFinestLevel),
                   {},    {}};
  std::ifstream layout(PHIZ_SOURCE_FOLDER "/samples/generic_head/base.json");
  world.layout = read_base_layout(layout);
  world.layout_triangles = triangulate_layout(world.layout);
  world.fits = fit_everything(bench, world.store);
  return world;
}

std::vector<std::string> list_adapt_subjects(const AdaptWorld& world) {
  std::vector<std::string> real, others;
  for (const BenchSubject& subject : world.bench.data.subjects) {
    const auto run = world.fits.subjects.find(subject.name);
    if (run == world.fits.subjects.end() || !run->second.is_done) continue;
    (subject.truth.empty() ? real : others).push_back(subject.name);
  }
  real.insert(real.end(), others.begin(), others.end());
  return real;
}

AdaptSubject load_adapt_subject(const AdaptWorld& world, const std::string& name) {
  const FittedHead fitted = load_fitted(world.store, world.fits.subjects.at(name), world.bench.head);
  AdaptSubject subject;
  subject.name = name;
  subject.control = fitted.control;
  subject.displacements_mm = fitted.displacements_mm;
  const UvSurface surface(world.chart, evaluate_finest(fitted, world.bench.head));
  subject.positions = to_float(surface.positions());
  subject.normals = to_float(surface.normals());
  subject.points = select_surface_points(world.chart, subject.positions, kDetail);
  std::vector<Eigen::Vector3d> places;
  for (const Eigen::Vector2d& uv : world.layout.uv) places.push_back(surface.position_at(uv));
  subject.face_base = make_base(world.layout.uv, world.layout_triangles, places);
  subject.base_faces = locate_in_base(subject.face_base.polyhedron, subject.points);
  return subject;
}

AdaptedMesh run_criterion(const AdaptWorld& world, const AdaptSubject& subject,
                          const CriterionOptions& options, std::optional<int> ordered_vertices) {
  LevelSampler sampler(world.chart, subject.positions, subject.normals);
  CriterionSurface surface(subject.face_base.polyhedron, sampler, subject.points, options,
                           subject.base_faces);
  AdaptiveMesh mesh(surface);
  AdaptedMesh made;
  AdaptBudget budget;
  if (ordered_vertices) budget.vertices = *ordered_vertices;
  made.report = ordered_vertices ? mesh.refine_in_order(budget) : mesh.refine(budget);
  made.mesh = mesh.to_triangle_mesh();
  return made;
}

Hausdorff measure_hausdorff(const TriangleMesh& mesh, std::span<const Eigen::Vector3f> surface,
                            const SurfaceIndex& surface_index) {
  constexpr double kFar = 1e6;
  Hausdorff distance;
  const SurfaceIndex index(mesh.positions, mesh.triangles);
  for (const SurfaceHit& hit : index.find_nearest(surface, kFar))
    distance.from_surface_mm = std::max(distance.from_surface_mm, hit.distance);
  std::vector<Eigen::Vector3f> places;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; i + j <= kSteps; ++j) {
        const float a = static_cast<float>(i) / kSteps, b = static_cast<float>(j) / kSteps;
        places.push_back(a * mesh.positions[t[0]] + b * mesh.positions[t[1]] +
                         (1 - a - b) * mesh.positions[t[2]]);
      }
    }
  }
  for (const SurfaceHit& hit : surface_index.find_nearest(places, kFar))
    distance.from_mesh_mm = std::max(distance.from_mesh_mm, hit.distance);
  return distance;
}

namespace {

void measure_adapt(const BenchWorld& bench) {
  const AdaptWorld world = make_adapt_world(bench);
  measure_bases(world);
  measure_adapt_speed(world);
  measure_equal_error(world);
  measure_operators(world);
  measure_clip(world);
  measure_walk(world);
}

}  // namespace
}  // namespace phiz::bench

int main(int argc, char** argv) {
  return phiz::bench::run_area("adapt", argc, argv, phiz::bench::measure_adapt);
}
