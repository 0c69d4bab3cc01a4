#include "tests/stages/unwrap/uv_samples.h"

#include <cmath>

#include "tests/support/random.h"

namespace phiz::test {

UvMesh random_uv_square(int cells) {
  UvMesh mesh;
  for (int y = 0; y <= cells; ++y) {
    for (int x = 0; x <= cells; ++x) {
      Eigen::Vector2d place(double(x) / cells, double(y) / cells);
      const double reach = 0.3 / cells;
      if (x > 0 && x < cells) place.x() += random().uniform(-reach, reach);
      if (y > 0 && y < cells) place.y() += random().uniform(-reach, reach);
      mesh.uv.push_back(place);
    }
  }
  for (int y = 0; y < cells; ++y) {
    for (int x = 0; x < cells; ++x) {
      const int a = y * (cells + 1) + x, b = a + 1, d = a + cells + 1, c = d + 1;
      mesh.triangles.insert(mesh.triangles.end(), {{a, b, c}, {a, c, d}});
    }
  }
  return mesh;
}

std::vector<Eigen::Vector3d> curved_sheet(const std::vector<Eigen::Vector2d>& uv) {
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector2d& p : uv)
    positions.emplace_back(80 * p.x(), 100 * p.y(), 10 * std::sin(2 * p.x()) + 6 * std::cos(3 * p.y()));
  return positions;
}

}  // namespace phiz::test
