#include "stages/subdivide/ring_normals.h"

#include <algorithm>
#include <cmath>

#include "stages/geometry/angle.h"
#include "stages/geometry/vector_clones.h"

namespace phiz {
namespace {

constexpr int kLanes = 8;
constexpr int kSpokes = 7;  ///< six neighbours, the first once more: triangles lie between consecutive spokes

/// Vectors from the centres to their neighbours, one lane a centre.
struct Spokes {
  double x[kSpokes][kLanes], y[kSpokes][kLanes], z[kSpokes][kLanes];
};

struct Lanes {
  double x[kLanes], y[kLanes], z[kLanes];
};

void gather(const Eigen::Vector3d* positions, const Eigen::Vector3d& centre,
            const SubdivisionHierarchy::Ring& ring, int lane, Spokes& spokes) {
  const bool on_border = ring[4] < 0;
  for (int i = 0; i < kSpokes; ++i) {
    // Past the end of an open fan the last spoke is repeated: triangles without an area weigh nothing.
    const int neighbour = on_border ? ring[i < 3 ? i : 3] : ring[i < 6 ? i : 0];
    spokes.x[i][lane] = positions[neighbour].x() - centre.x();
    spokes.y[i][lane] = positions[neighbour].y() - centre.y();
    spokes.z[i][lane] = positions[neighbour].z() - centre.z();
  }
}

PHIZ_VECTOR_CLONES void sum_faces(const Spokes& s, Lanes& sum) {
  for (int k = 0; k < kLanes; ++k) sum.x[k] = sum.y[k] = sum.z[k] = 0;
  for (int i = 0; i + 1 < kSpokes; ++i)
    for (int k = 0; k < kLanes; ++k) {
      const double nx = s.y[i][k] * s.z[i + 1][k] - s.z[i][k] * s.y[i + 1][k];
      const double ny = s.z[i][k] * s.x[i + 1][k] - s.x[i][k] * s.z[i + 1][k];
      const double nz = s.x[i][k] * s.y[i + 1][k] - s.y[i][k] * s.x[i + 1][k];
      const double dot = s.x[i][k] * s.x[i + 1][k] + s.y[i][k] * s.y[i + 1][k] + s.z[i][k] * s.z[i + 1][k];
      const double length = std::sqrt(nx * nx + ny * ny + nz * nz);
      const double weight = angle_of(length, dot) / (length > 0 ? length : 1.0);
      sum.x[k] += weight * nx;
      sum.y[k] += weight * ny;
      sum.z[k] += weight * nz;
    }
}

void normalise(Lanes& n) {
  for (int k = 0; k < kLanes; ++k) {
    const double length = std::sqrt(n.x[k] * n.x[k] + n.y[k] * n.y[k] + n.z[k] * n.z[k]);
    const double scale = 1 / (length > 0 ? length : 1.0);
    n.x[k] *= scale;
    n.y[k] *= scale;
    n.z[k] *= scale;
  }
}

}  // namespace

void compute_ring_normals(std::span<const Eigen::Vector3d> positions,
                          std::span<const Eigen::Vector3d> centres,
                          std::span<const SubdivisionHierarchy::Ring> rings,
                          std::span<Eigen::Vector3d> normals) {
  Spokes spokes;
  Lanes sum;
  for (std::size_t begin = 0; begin < rings.size(); begin += kLanes) {
    const std::size_t count = std::min<std::size_t>(kLanes, rings.size() - begin);
    for (std::size_t k = 0; k < kLanes; ++k) {  // the last block repeats its last ring
      const std::size_t i = begin + std::min(k, count - 1);
      gather(positions.data(), centres[i], rings[i], static_cast<int>(k), spokes);
    }
    sum_faces(spokes, sum);
    normalise(sum);
    for (std::size_t k = 0; k < count; ++k) normals[begin + k] = {sum.x[k], sum.y[k], sum.z[k]};
  }
}

}  // namespace phiz
