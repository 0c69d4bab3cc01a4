#include <algorithm>
#include <chrono>

#include "stages/align/mesh_silhouette.h"
#include "tests/bench/areas.h"

namespace phiz::bench {
namespace {

constexpr int kSizePx = 256, kBatches = 7, kEvaluations = 500;

AffineMatrix shifted(double step_mm) {
  AffineMatrix matrix = AffineMatrix::Zero();
  matrix.leftCols<3>().setIdentity();
  matrix.col(3).setConstant(step_mm);
  return matrix;
}

}  // namespace

void measure_silhouettes(const BenchWorld& world) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& position : world.head.mesh.positions) box.extend(position);
  const SilhouetteFrame frame = make_silhouette_frame(box, kSizePx);
  const SilhouetteMesh mesh(to_float(world.head.mesh.positions), world.head.mesh.triangles);
  SilhouetteRasteriser rasteriser;
  std::array<Silhouette, 3> goal, picture;
  rasteriser.rasterise(mesh, shifted(0), frame, goal);

  std::vector<double> milliseconds;
  std::int64_t white = 0;                            // printed, so that nothing is left out
  for (int batch = 0; batch <= kBatches; ++batch) {  // the first one warms up
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < kEvaluations; ++i) {
      rasteriser.rasterise(mesh, shifted(0.01 * i), frame, picture);
      for (int view = 0; view < 3; ++view) white += count_xor(goal[view], picture[view]);
    }
    const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - begin;
    if (batch > 0) milliseconds.push_back(time.count() / kEvaluations);
  }
  world.board.add(
      {"one silhouette evaluation, three views of 256 x 256", median(milliseconds), "ms", at_most(0.2)});
  world.board.note("white pixels counted: " + std::to_string(white));
}

}  // namespace phiz::bench
