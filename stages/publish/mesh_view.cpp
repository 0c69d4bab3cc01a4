#include <cmath>

#include "stages/geometry/error.h"
#include "stages/publish/view_parts.h"

namespace phiz {
namespace {

constexpr int kMeshSamples = 3;

std::vector<Eigen::Vector3f> average_normals(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3f> normals(mesh.vertex_count(), Eigen::Vector3f::Zero());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3f& a = mesh.positions[t.x()];
    const Eigen::Vector3f normal = (mesh.positions[t.y()] - a).cross(mesh.positions[t.z()] - a);
    if (!normal.allFinite()) continue;
    for (int corner = 0; corner < 3; ++corner) normals[t[corner]] += normal;
  }
  return normals;
}

struct MeshScene {
  const TriangleMesh& mesh;
  const ViewOptions& options;
  std::vector<Eigen::Vector3f> corners;  ///< in samples
  std::vector<Eigen::Vector3f> normals;  ///< in the view
  std::vector<Eigen::Vector3f> colours;  ///< empty: clay
  Eigen::Vector3f clay;
};

struct Corners {
  Eigen::Vector3f a, b, c;
  float area;  ///< twice the area on the screen, > 0 where seen from outside
};

Corners find_corners(const MeshScene& scene, std::int32_t triangle_idx) {
  const Eigen::Vector3i& t = scene.mesh.triangles[triangle_idx];
  Corners corners{scene.corners[t.x()], scene.corners[t.y()], scene.corners[t.z()], 0};
  const Eigen::Vector3f u = corners.b - corners.a, v = corners.c - corners.a;
  corners.area = u.y() * v.x() - u.x() * v.y();
  return corners;
}

Eigen::Vector3f find_weights(const Corners& k, float x, float y) {
  const float bx = k.b.x() - x, by = k.b.y() - y, cx = k.c.x() - x, cy = k.c.y() - y, ax = k.a.x() - x,
              ay = k.a.y() - y;
  Eigen::Vector3f w(by * cx - bx * cy, cy * ax - cx * ay, ay * bx - ax * by);
  if (k.area < 0) w = -w;
  w = w.cwiseMax(0.0f);
  const float sum = w.sum();
  return sum > 0 ? Eigen::Vector3f(w / sum) : Eigen::Vector3f::Constant(1.0f / 3);
}

// How much of the line colour an edge of the triangle lays on this place. Lines grow fainter where triangles
// are smaller than a few pixels, so that dense parts stay readable.
float find_line_share(const Corners& k, const Eigen::Vector3f& weights) {
  constexpr float kHalfWidth = 0.55f * kMeshSamples, kSoft = 0.5f * kMeshSamples;
  const float area = std::abs(k.area);
  float share = 0;
  const auto add_edge = [&](const Eigen::Vector3f& p, const Eigen::Vector3f& q, float weight) {
    const float length = std::sqrt((q - p).head<2>().squaredNorm());
    if (length <= 0) return;
    const float height = area / length;
    const float cover = std::clamp((kHalfWidth + kSoft * 0.5f - weight * height) / kSoft, 0.0f, 1.0f);
    share = std::max(share, cover * std::clamp(height / (8.0f * kMeshSamples), 0.12f, 0.9f));
  };
  add_edge(k.b, k.c, weights.x());
  add_edge(k.c, k.a, weights.y());
  add_edge(k.a, k.b, weights.z());
  return share;
}

// Not of unit length; towards the outside of the triangle.
Eigen::Vector3f find_normal(const MeshScene& scene, std::int32_t triangle_idx, const Corners& k,
                            const Eigen::Vector3f& w) {
  if (scene.options.flat) {
    const Eigen::Vector3f u = k.b - k.a,
                          v = k.c - k.a;  // in samples: y runs down, which mirrors the cross product
    return {u.z() * v.y() - u.y() * v.z(), u.z() * v.x() - u.x() * v.z(), u.y() * v.x() - u.x() * v.y()};
  }
  const Eigen::Vector3i& t = scene.mesh.triangles[triangle_idx];
  return scene.normals[t.x()] * w.x() + scene.normals[t.y()] * w.y() + scene.normals[t.z()] * w.z();
}

Eigen::Vector3f shade_sample(const MeshScene& scene, std::int32_t triangle_idx, float x, float y) {
  const Eigen::Vector3i& t = scene.mesh.triangles[triangle_idx];
  const Corners corners = find_corners(scene, triangle_idx);
  const Eigen::Vector3f w = find_weights(corners, x, y);
  const bool from_behind = corners.area < 0;
  Eigen::Vector3f normal = find_normal(scene, triangle_idx, corners, w);
  const float length = std::sqrt(normal.squaredNorm());
  if (length > 0) {
    normal *= (from_behind ? -1.0f : 1.0f) / length;
  } else {
    normal = Eigen::Vector3f::UnitZ();
  }
  Eigen::Vector3f colour = scene.clay;
  if (!scene.colours.empty())
    colour = scene.colours[t.x()] * w.x() + scene.colours[t.y()] * w.y() + scene.colours[t.z()] * w.z();
  colour = light_surface(scene.options, colour, normal, from_behind);
  if (scene.options.wireframe) {
    const float share = find_line_share(corners, w);
    colour = colour * (1 - share) + Eigen::Vector3f(0.012f, 0.022f, 0.06f) * share;
  }
  return colour;
}

std::pair<int, int> find_rows(const MeshScene& scene, int triangle_idx) {
  const Eigen::Vector3i& t = scene.mesh.triangles[triangle_idx];
  const float a = scene.corners[t.x()].y(), b = scene.corners[t.y()].y(), c = scene.corners[t.z()].y();
  if (std::isnan(a + b + c)) return {0, -1};
  return {static_cast<int>(std::floor(std::min({a, b, c}))),
          static_cast<int>(std::floor(std::max({a, b, c})))};
}

}  // namespace

Image render_mesh(const TriangleMesh& mesh, const ViewOptions& options) {
  check_heat(options, mesh.vertex_count());
  const auto count = static_cast<int>(mesh.vertex_count());
  for (const Eigen::Vector3i& t : mesh.triangles)
    if (t.minCoeff() < 0 || t.maxCoeff() >= count)
      throw InvalidInput("triangle with a vertex index out of range");
  const Screen screen = make_screen(options, mesh.positions, {.samples = kMeshSamples});
  MeshScene scene{mesh, options, project_all(screen, mesh.positions), {}, {}, decode_colour(options.clay)};
  scene.colours = find_colours(options, mesh.colours, mesh.vertex_count());
  if (!options.flat) {
    const bool own_normals = mesh.normals.size() == mesh.vertex_count();
    scene.normals = turn_normals(screen, own_normals ? mesh.normals : average_normals(mesh));
  }
  const BandBins bins(static_cast<int>(mesh.triangle_count()), screen.height, kBandPixels * kMeshSamples,
                      [&](int i) { return find_rows(scene, i); });
  PixelLayer layer = draw_bands(
      screen, bins,
      [&](std::int32_t i, SampleBand& band) {
        const Eigen::Vector3i& t = mesh.triangles[i];
        draw_triangle({scene.corners[t.x()], scene.corners[t.y()], scene.corners[t.z()]}, i, band);
      },
      [&](std::int32_t i, float x, float y) { return shade_sample(scene, i, x, y); });
  return finish_view(layer, options);
}

}  // namespace phiz
