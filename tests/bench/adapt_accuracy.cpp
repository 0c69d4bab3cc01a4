#include <fmt/format.h>

#include <cmath>
#include <functional>

#include "tests/bench/adapt.h"

namespace phiz::bench {
namespace {

constexpr int kDepth = 3, kPaperDepth = 5;  ///< the second gives about the paper's 3,400 vertices
constexpr int kSearches = 13;
constexpr int kPaperVertices = 3400;

std::vector<Eigen::Vector3d> layout_places(const AdaptWorld& world, const AdaptSubject& subject) {
  LevelSampler sampler(world.chart, subject.positions, subject.normals);
  std::vector<Eigen::Vector3d> places;
  for (const Eigen::Vector2d& uv : world.layout.uv)
    places.push_back(sampler.sample(0, uv).position.cast<double>());
  return places;
}

CriterionOptions options_of(Criterion criterion, double tolerance, ContourNorm norm = ContourNorm::kMaximum) {
  CriterionOptions options;
  options.criterion = criterion;
  options.norm = norm;
  options.tolerance = tolerance;
  options.depth = kDepth;
  return options;
}

/// Fewest vertices with no more than `error`, among meshes made with a parameter searched between `low`
/// (finer) and `high` (coarser), in equal steps of its logarithm.
struct Found {
  int vertices = 0;
  double error_mm = 0, parameter = 0;
};
Found find_fewest(double error, double low, double high,
                  const std::function<std::pair<int, double>(double)>& make) {
  Found best;
  for (int k = 0; k < kSearches; ++k) {
    const double middle = std::sqrt(low * high);
    const auto [vertices, its_error] = make(middle);
    const bool is_good = its_error <= error;
    if (is_good && (best.vertices == 0 || vertices < best.vertices)) best = {vertices, its_error, middle};
    (is_good ? low : high) = middle;
  }
  return best;
}

struct Shares {
  std::vector<double> normals, contour, average, integral, ordered;
};

/// One subject: everything at the error of uniform refinement, and in order against contour.
void compare(const AdaptWorld& world, const AdaptSubject& subject, int depth, Shares& shares) {
  const SurfaceIndex index(subject.positions, world.chart.hierarchy.triangles(kFinestLevel));
  const auto judge = [&](const AdaptedMesh& made) {
    return measure_hausdorff(made.mesh, subject.positions, index);
  };
  CriterionOptions uniform = options_of(Criterion::kUniform, 1);
  uniform.depth = depth;
  const AdaptedMesh all = run_criterion(world, subject, uniform);
  const Hausdorff error = judge(all);
  world.bench.board.note(fmt::format("{}: unconditional depth {}: {} vertices, {:.3f} mm ({:.3f} / {:.3f})",
                                     subject.name, depth, all.vertices(), error.both(), error.from_surface_mm,
                                     error.from_mesh_mm));
  const auto add = [&](const char* name, std::vector<double>& list, const Found& found) {
    list.push_back(found.vertices == 0 ? NAN : 100.0 * found.vertices / all.vertices());
    world.bench.board.note(fmt::format("{}:   {}: {} vertices ({:.1f} %), {:.3f} mm, at {:.4g}", subject.name,
                                       name, found.vertices, list.back(), found.error_mm, found.parameter));
  };
  const auto search = [&](Criterion criterion, ContourNorm norm, double low, double high) {
    return find_fewest(error.both(), low, high, [&](double tolerance) {
      const AdaptedMesh made = run_criterion(world, subject, options_of(criterion, tolerance, norm));
      return std::pair(made.vertices(), judge(made).both());
    });
  };
  const double e = error.both();
  add("normals", shares.normals, search(Criterion::kNormals, ContourNorm::kMaximum, 0.02 * e, 4 * e));
  add("contour", shares.contour, search(Criterion::kContour, ContourNorm::kMaximum, 0.2 * e, 8 * e));
  if (depth == kDepth) {
    add("contour, average", shares.average,
        search(Criterion::kContour, ContourNorm::kAverage, 0.02 * e, 2 * e));
    add("contour, integral", shares.integral,
        search(Criterion::kContour, ContourNorm::kIntegral, e, 2000 * e));
  }
  add("in order", shares.ordered,
      find_fewest(error.both(), 1.0 * all.vertices(), 0.02 * all.vertices(), [&](double count) {
        const AdaptedMesh made =
            run_criterion(world, subject, options_of(Criterion::kDistance, 1), static_cast<int>(count));
        return std::pair(made.vertices(), judge(made).both());
      }));
}

void compare_order(const AdaptWorld& world, const AdaptSubject& subject, std::vector<double>& ratios) {
  const SurfaceIndex index(subject.positions, world.chart.hierarchy.triangles(kFinestLevel));
  double low = 0.05, high = 20;
  AdaptedMesh contour;
  for (int k = 0; k < kSearches; ++k) {
    const double middle = std::sqrt(low * high);
    AdaptedMesh made = run_criterion(world, subject, options_of(Criterion::kContour, middle));
    const bool is_few = made.vertices() <= kPaperVertices;
    if (is_few) contour = std::move(made);
    (is_few ? high : low) = middle;
  }
  const AdaptedMesh ordered =
      run_criterion(world, subject, options_of(Criterion::kDistance, 1), contour.vertices());
  const Hausdorff a = measure_hausdorff(contour.mesh, subject.positions, index),
                  b = measure_hausdorff(ordered.mesh, subject.positions, index);
  ratios.push_back(b.both() / a.both());
  world.bench.board.note(fmt::format(
      "{}: contour {} vertices {:.3f} / {:.3f} mm, in order {} vertices {:.3f} / {:.3f} mm, own error {:.3f}",
      subject.name, contour.vertices(), a.from_surface_mm, a.from_mesh_mm, ordered.vertices(),
      b.from_surface_mm, b.from_mesh_mm, ordered.report.error));
}

}  // namespace

void measure_bases(const AdaptWorld& world) {
  const AdaptSubject subject = load_adapt_subject(world, list_adapt_subjects(world).at(0));
  const auto places = layout_places(world, subject);
  const double given = static_cast<double>(places.size());
  for (const BlockOrder order : {BlockOrder::kMatching, BlockOrder::kLongestFirst}) {
    const CompliantMesh made = make_compliant(world.layout_triangles, places, order);
    const bool is_matching = order == BlockOrder::kMatching;
    world.bench.board.note(fmt::format(
        "{}: {} vertices {} triangles become {} / {}: {} pairs, {} alone on the border, {} alone inside; "
        "paper 113 / 195 become 233 / 414",
        is_matching ? "perfect matching" : "longest edge first", places.size(), world.layout_triangles.size(),
        made.vertex_count, made.triangles.size(), made.pairs, made.border_singles, made.inside_singles));
    const bool is_good = is_compliant(made.triangles, made.vertex_count);
    world.bench.board.add({is_matching
                               ? "compliant base by perfect matching, vertices over those given (paper 2.06)"
                               : "the same with every pair split once, longest edge first",
                           is_good ? made.vertex_count / given : NAN, "x", at_most(2.1)});
  }
}

void measure_equal_error(const AdaptWorld& world) {
  Shares shares, finer;
  std::vector<double> ratios;
  for (const std::string& name : list_adapt_subjects(world)) {
    const AdaptSubject subject = load_adapt_subject(world, name);
    compare(world, subject, kDepth, shares);
    compare(world, subject, kPaperDepth, finer);
    compare_order(world, subject, ratios);
    if (!world.bench.is_long && ratios.size() >= 3) break;
  }
  Board& board = world.bench.board;
  board.add({"vertices of normals for the error of unconditional depth 3, mean (paper 56)",
             mean(shares.normals), "%", at_most(45)});
  board.add({"vertices of contour, maximum, likewise (paper 40)", mean(shares.contour), "%", at_most(25)});
  board.add({"vertices of contour, average", mean(shares.average), "%", {}});
  board.add({"vertices of contour, integral", mean(shares.integral), "%", {}});
  board.add({"vertices in order of distance", mean(shares.ordered), "%", {}});
  board.add({"the same for depth 5, about 3,400 vertices: normals, mean (paper 56)", mean(finer.normals), "%",
             at_most(45)});
  board.add(
      {"the same for depth 5: contour, maximum, mean (paper 40)", mean(finer.contour), "%", at_most(25)});
  board.add({"the same for depth 5: in order of distance", mean(finer.ordered), "%", {}});
  board.add(
      {"in order, error over that of contour at equal vertices, mean", mean(ratios), "x", at_most(0.85)});
}

}  // namespace phiz::bench
