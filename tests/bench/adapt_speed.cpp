#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tests/bench/adapt.h"

namespace phiz::bench {
namespace {

constexpr int kVertices = 3400, kRuns = 31, kSearches = 24;
constexpr int kUniformDepth = 5;  ///< of the face base: 195 * 2^5 triangles

struct Timed {
  int vertices = 0;
  double ms = 0, median_ms = 0;
};

/// From the base to the mesh: topology, (u,v), samples, tests. The best of the runs after a warm-up, as
/// others may use the machine.
Timed time_refinement(const AdaptWorld& world, const AdaptSubject& subject, const CriterionOptions& options) {
  LevelSampler sampler(world.chart, subject.positions, subject.normals);
  Timed timed;
  std::vector<double> times;
  for (int run = 0; run <= kRuns; ++run) {
    const double start = processor_seconds();
    CriterionSurface surface(subject.face_base.polyhedron, sampler, subject.points, options,
                             subject.base_faces);
    AdaptiveMesh mesh(surface);
    mesh.refine();
    if (run > 0) times.push_back(1e3 * (processor_seconds() - start));
    timed.vertices = mesh.mesh().vertex_count();
  }
  timed.ms = quantile(times, 0);
  timed.median_ms = median(times);
  return timed;
}

/// The tolerance that comes nearest to the wanted number of vertices.
CriterionOptions find_tolerance(const AdaptWorld& world, const AdaptSubject& subject, Criterion criterion) {
  CriterionOptions options, best;
  options.criterion = criterion;
  double low = 1e-3, high = 50;
  int gap = kVertices;
  for (int k = 0; k < kSearches; ++k) {
    options.tolerance = std::sqrt(low * high);
    const int vertices = run_criterion(world, subject, options).vertices();
    if (std::abs(vertices - kVertices) < gap) {
      gap = std::abs(vertices - kVertices);
      best = options;
    }
    (vertices > kVertices ? low : high) = options.tolerance;
  }
  return best;
}

}  // namespace

void measure_adapt_speed(const AdaptWorld& world) {
  const AdaptSubject subject = load_adapt_subject(world, list_adapt_subjects(world).at(0));
  Board& board = world.bench.board;
  CriterionOptions uniform;
  uniform.criterion = Criterion::kUniform;
  uniform.depth = kUniformDepth;
  const auto add = [&](const char* name, const CriterionOptions& options, const char* paper, double bar) {
    const Timed timed = time_refinement(world, subject, options);
    board.note(fmt::format("{}: {} vertices on {}, median {:.2f} ms", name, timed.vertices, subject.name,
                           timed.median_ms));
    board.add({fmt::format("refine to about 3,400 vertices, {} (paper {})", name, paper), timed.ms, "ms",
               at_most(bar)});
  };
  add("unconditional", uniform, "0.7 s", 2);
  add("normals", find_tolerance(world, subject, Criterion::kNormals), "0.7 s", 2);
  add("contour", find_tolerance(world, subject, Criterion::kContour), "2.5 s", 12);
  std::vector<double> level_times, point_times;
  for (int run = 0; run < 5; ++run) {
    double start = processor_seconds();
    const auto level = evaluate_surface(world.chart.hierarchy, subject.control, subject.displacements_mm, 4);
    level_times.push_back(1e3 * (processor_seconds() - start));
    start = processor_seconds();
    select_surface_points(world.chart, subject.positions, 0.05);
    point_times.push_back(1e3 * (processor_seconds() - start));
  }
  board.add({"made once a subject before: its level 4 (processor time of one of the threads)",
             median(level_times),
             "ms",
             {}});
  board.add({fmt::format("made once a subject before: its {} points for contour", subject.points.uv.size()),
             median(point_times),
             "ms",
             {}});
}

}  // namespace phiz::bench
