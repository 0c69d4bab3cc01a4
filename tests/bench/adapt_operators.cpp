#include <fmt/format.h>

#include <algorithm>

#include "tests/bench/adapt.h"
#include "tests/support/mesh_zoo.h"
#include "tests/support/random.h"

namespace phiz::bench {
namespace {

constexpr int kSide = 64;   ///< cells of the grid: 8,192 triangles
constexpr int kLevels = 7;  ///< 1,048,576
constexpr int kRandomOperators = 2'000'000;
constexpr long long kRequests = 10'000'000;
constexpr int kValidateEvery = 20'000;

CompliantMesh compliant_of(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3f& p : mesh.positions) positions.push_back(p.cast<double>());
  return make_compliant(mesh.triangles, positions);
}

/// All vertices of the finest level away and there again, in the order of slots.
double time_sweeps(MultiTriangulation& mesh, long long& operators) {
  const auto count = [&](const StellarChange&) { ++operators; };
  const double start = processor_seconds();
  for (int round = 0; round < 4; ++round) {
    for (int v = mesh.base_vertex_count(); v < mesh.mesh().vertex_slots(); ++v)
      if (mesh.mesh().is_vertex(v) && mesh.vertex_level(v) == kLevels) mesh.simplify(v, count);
    for (int f = 0; f < mesh.mesh().face_slots(); ++f)
      if (mesh.mesh().is_face(f) && mesh.level(f) == kLevels - 1) mesh.refine(f, count);
  }
  return processor_seconds() - start;
}

/// Anywhere in the mesh, as many splits as welds.
double time_random(MultiTriangulation& mesh, long long& operators) {
  test::Random dice(1);
  const auto count = [&](const StellarChange&) { ++operators; };
  const double start = processor_seconds();
  while (operators < kRandomOperators) {
    const int v = static_cast<int>(dice.below(mesh.mesh().vertex_slots()));
    if (mesh.mesh().is_vertex(v) && mesh.can_weld(v)) mesh.simplify(v, count);
    const int f = static_cast<int>(dice.below(mesh.mesh().face_slots()));
    if (mesh.mesh().is_face(f) && mesh.level(f) < kLevels) mesh.refine(f, count);
  }
  return processor_seconds() - start;
}

/// The plane: positions are (u,v).
class PlaneSurface final : public AdaptiveSurface {
 public:
  explicit PlaneSurface(BasePolyhedron base) : base_(std::move(base)) {}
  const BasePolyhedron& base() const override { return base_; }
  VertexSample sample(const AdaptiveMesh&, const NewVertex& place) override {
    return {Eigen::Vector3f(static_cast<float>(place.uv.x()), static_cast<float>(place.uv.y()), 0),
            Eigen::Vector3f::UnitZ()};
  }
  bool should_refine(const AdaptiveMesh& mesh, int f) override {
    return mesh.triangulation().level(f) < kLevels;
  }
  bool may_simplify(const AdaptiveMesh&, const StellarChange&) override { return false; }

 private:
  BasePolyhedron base_;
};

/// One mesh of the zoo, so many requests; what went wrong, or nothing.
std::string walk(const std::string& name, const TriangleMesh& zoo, long long requests) {
  const CompliantMesh base = compliant_of(zoo);
  MultiTriangulation mesh(base.triangles, base.vertex_count);
  test::Random dice(test::seed_of_test(name));
  const auto nothing = [](const StellarChange&) {};
  const int most = std::max(4000, 4 * mesh.base_face_count());
  for (long long request = 0; request < requests;) {
    const bool is_refining = dice.below(1000) < (mesh.mesh().face_count() < most ? 550u : 450u);
    if (is_refining) {
      const int f = static_cast<int>(dice.below(mesh.mesh().face_slots()));
      if (!mesh.mesh().is_face(f) || mesh.level(f) >= MultiTriangulation::kMostLevel) continue;
      mesh.refine(f, nothing);
    } else {
      const int v = static_cast<int>(dice.below(mesh.mesh().vertex_slots()));
      if (!mesh.mesh().is_vertex(v)) continue;
      if (mesh.vertex_level(v) > 0)
        mesh.simplify(v, nothing);
      else if (mesh.mesh().vertex_count() > mesh.base_vertex_count())
        continue;
    }
    if (++request % kValidateEvery == 0) {
      const std::vector<std::string> broken = mesh.validate();
      if (!broken.empty()) return name + ": " + broken.front();
    }
  }
  for (int v = mesh.base_vertex_count(); v < mesh.mesh().vertex_slots(); ++v)
    if (mesh.mesh().is_vertex(v)) mesh.simplify(v, nothing);
  if (!mesh.validate().empty() || mesh.mesh().face_count() != mesh.base_face_count())
    return name + ": the base does not come back";
  for (int f = 0; f < mesh.base_face_count(); ++f)
    for (int i = 0; i < 3; ++i)
      if (mesh.mesh().corners(f)[i] != base.triangles[f][i]) return name + ": the base comes back changed";
  return {};
}

}  // namespace

void measure_operators(const AdaptWorld& world) {
  Board& board = world.bench.board;
  const TriangleMesh grid = test::open_grid(kSide, kSide);
  const CompliantMesh base = compliant_of(grid);
  BasePolyhedron polyhedron;
  for (const Eigen::Vector3f& p : grid.positions) polyhedron.uv.push_back(p.head<2>().cast<double>());
  polyhedron.triangles = base.triangles;
  PlaneSurface plane(polyhedron);
  AdaptiveMesh adaptive(plane);
  adaptive.set_recording(false);
  adaptive.refine();
  board.add({fmt::format("memory a triangle, positions, normals and (u,v) included, {} triangles",
                         adaptive.mesh().face_count()),
             static_cast<double>(adaptive.memory_bytes()) / adaptive.mesh().face_count(), "bytes",
             at_most(120)});
  MultiTriangulation mesh = adaptive.triangulation();
  std::vector<double> sweeps, randoms;
  for (int run = 0; run < 5; ++run) {
    long long swept = 0, thrown = 0;
    const double sweep_time = time_sweeps(mesh, swept);
    sweeps.push_back(1e-6 * static_cast<double>(swept) / sweep_time);
    MultiTriangulation copy = mesh;
    const double random_time = time_random(copy, thrown);
    randoms.push_back(1e-6 * static_cast<double>(thrown) / random_time);
  }
  board.add({"splits and welds a second, no sampling, a mesh of 1 M triangles, in the order of slots",
             median(sweeps), "million", at_least(3)});
  board.add({"the same at random places", median(randoms), "million", {}});
  board.note(mesh.validate().empty() ? "valid afterwards" : "NOT valid afterwards");
}

void measure_walk(const AdaptWorld& world) {
  const std::vector<test::NamedMesh> zoo = test::mesh_zoo();
  const long long each = kRequests / static_cast<long long>(zoo.size()) + 1;
  double broken = 0;
  const double start = processor_seconds();
  for (const auto& [name, mesh] : zoo) {
    const std::string what = walk(name, mesh, each);
    if (!what.empty()) world.bench.board.note(what);
    broken += !what.empty();
  }
  world.bench.board.note(fmt::format("{} requests on {} meshes, {:.1f} s",
                                     each * static_cast<long long>(zoo.size()), zoo.size(),
                                     processor_seconds() - start));
  world.bench.board.add({"random walk of 10 million requests: meshes that were invalid or did not come back",
                         broken, "", at_most(0)});
}

}  // namespace phiz::bench
