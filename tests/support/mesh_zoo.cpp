#include "tests/support/mesh_zoo.h"

#include <cmath>
#include <map>
#include <utility>

namespace phiz::test {
namespace {

constexpr double kTwoPi = 6.283185307179586476925;

Eigen::Vector3f on_unit_sphere(double x, double y, double z) {
  return Eigen::Vector3d(x, y, z).normalized().cast<float>();
}

/// Two triangles for the cell a-b (bottom), d-c (top), counter-clockwise.
void add_quad(TriangleMesh& mesh, int a, int b, int c, int d) {
  mesh.triangles.emplace_back(a, b, c);
  mesh.triangles.emplace_back(a, c, d);
}

TriangleMesh split_once(const TriangleMesh& coarse) {
  TriangleMesh fine;
  fine.positions = coarse.positions;
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [entry, is_new] =
        middles.try_emplace(std::minmax(a, b), static_cast<int>(fine.positions.size()));
    if (is_new) {
      const Eigen::Vector3d sum = (coarse.positions[a] + coarse.positions[b]).cast<double>();
      fine.positions.push_back(on_unit_sphere(sum.x(), sum.y(), sum.z()));
    }
    return entry->second;
  };
  for (const Eigen::Vector3i& t : coarse.triangles) {
    const int ab = middle(t[0], t[1]), bc = middle(t[1], t[2]), ca = middle(t[2], t[0]);
    fine.triangles.emplace_back(t[0], ab, ca);
    fine.triangles.emplace_back(t[1], bc, ab);
    fine.triangles.emplace_back(t[2], ca, bc);
    fine.triangles.emplace_back(ab, bc, ca);
  }
  return fine;
}

}  // namespace

TriangleMesh single_triangle() {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

TriangleMesh tetrahedron() {
  TriangleMesh mesh;
  mesh.positions = {on_unit_sphere(1, 1, 1), on_unit_sphere(1, -1, -1), on_unit_sphere(-1, 1, -1),
                    on_unit_sphere(-1, -1, 1)};
  mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  return mesh;
}

TriangleMesh icosphere(int level) {
  const double g = (1.0 + std::sqrt(5.0)) / 2.0;
  TriangleMesh mesh;
  mesh.positions = {on_unit_sphere(-1, g, 0),  on_unit_sphere(1, g, 0),   on_unit_sphere(-1, -g, 0),
                    on_unit_sphere(1, -g, 0),  on_unit_sphere(0, -1, g),  on_unit_sphere(0, 1, g),
                    on_unit_sphere(0, -1, -g), on_unit_sphere(0, 1, -g),  on_unit_sphere(g, 0, -1),
                    on_unit_sphere(g, 0, 1),   on_unit_sphere(-g, 0, -1), on_unit_sphere(-g, 0, 1)};
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int k = 0; k < level; ++k) mesh = split_once(mesh);
  return mesh;
}

TriangleMesh open_grid(int columns, int rows) {
  TriangleMesh mesh;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i)
      mesh.positions.emplace_back(static_cast<float>(i) / static_cast<float>(columns),
                                  static_cast<float>(j) / static_cast<float>(rows), 0.0f);
  const int stride = columns + 1;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const int a = j * stride + i;
      add_quad(mesh, a, a + 1, a + stride + 1, a + stride);
    }
  return mesh;
}

TriangleMesh disk(int sectors, int rings) {
  TriangleMesh mesh;
  mesh.positions.emplace_back(0.0f, 0.0f, 0.0f);
  for (int ring = 1; ring <= rings; ++ring)
    for (int s = 0; s < sectors; ++s) {
      const double radius = static_cast<double>(ring) / rings, angle = kTwoPi * s / sectors;
      mesh.positions.push_back(
          Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), 0.0).cast<float>());
    }
  const auto at = [&](int ring, int s) { return 1 + (ring - 1) * sectors + s % sectors; };
  for (int s = 0; s < sectors; ++s) mesh.triangles.emplace_back(0, at(1, s), at(1, s + 1));
  for (int ring = 1; ring < rings; ++ring)
    for (int s = 0; s < sectors; ++s)
      add_quad(mesh, at(ring, s), at(ring + 1, s), at(ring + 1, s + 1), at(ring, s + 1));
  return mesh;
}

TriangleMesh torus(int around, int across) {
  constexpr double kMinorRadius = 0.4;
  TriangleMesh mesh;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double a = kTwoPi * i / around, b = kTwoPi * j / across;
      const double from_axis = 1.0 + kMinorRadius * std::cos(b);
      mesh.positions.push_back(
          Eigen::Vector3d(from_axis * std::cos(a), from_axis * std::sin(a), kMinorRadius * std::sin(b))
              .cast<float>());
    }
  const auto at = [&](int i, int j) { return (i % around) * across + j % across; };
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) add_quad(mesh, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
  return mesh;
}

TriangleMesh sliver_mesh() {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0},     {1, 0, 0},        {2, 0, 0}, {0, 1e-6f, 0}, {1, 1, 0},
                    {2, 1e-4f, 0}, {1.5f, 1e-7f, 0}, {3, 0, 0}, {3, 0, 0},     {0.5f, 0, 0}};
  mesh.triangles = {{0, 1, 3}, {1, 4, 3}, {1, 2, 6}, {1, 6, 4}, {6, 2, 5},
                    {6, 5, 4}, {2, 7, 5}, {7, 8, 5}, {1, 0, 9}};
  return mesh;
}

std::vector<NamedMesh> mesh_zoo() {
  return {{"single_triangle", single_triangle()},
          {"tetrahedron", tetrahedron()},
          {"icosphere_0", icosphere(0)},
          {"icosphere_2", icosphere(2)},
          {"open_grid_5x3", open_grid(5, 3)},
          {"disk_5x3", disk(5, 3)},
          {"disk_9x2", disk(9, 2)},
          {"torus_12x7", torus(12, 7)},
          {"slivers", sliver_mesh()}};
}

}  // namespace phiz::test
