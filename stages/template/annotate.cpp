#include "stages/template/annotate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "stages/geometry/error.h"
#include "stages/geometry/surface_index.h"
#include "stages/template/tidy.h"

namespace phiz {
namespace {

using Edge = std::pair<int, int>;

double doubled_area(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// The triangle of the half square that holds a place: the one whose smallest weight is largest.
int find_triangle(const HalfMesh& half, const Eigen::Vector2d& uv) {
  int best = -1;
  double best_weight = -std::numeric_limits<double>::infinity();
  for (int t = 0; t < static_cast<int>(half.triangles.size()); ++t) {
    std::array<Eigen::Vector2d, 3> p;
    for (int k = 0; k < 3; ++k) p[k] = half.vertices[half.triangles[t][k]].uv;
    const double area = doubled_area(p[0], p[1], p[2]);
    double smallest = 1;
    for (int k = 0; k < 3; ++k) smallest = std::min(smallest, doubled_area(uv, p[k], p[(k + 1) % 3]) / area);
    if (smallest > best_weight) best_weight = smallest, best = t;
  }
  return best;
}

/// Weights in [0,1] with sum 1, on the grain.
Eigen::Vector3d tidy_weights(Eigen::Vector3d weights) {
  weights = weights.cwiseMax(0);
  weights /= weights.sum();
  int largest = 0;
  weights.maxCoeff(&largest);
  double others = 0;
  for (int k = 0; k < 3; ++k) {
    if (k == largest) continue;
    weights[k] = on_grain(weights[k]);
    others += weights[k];
  }
  weights[largest] = on_grain(1 - others);
  return weights;
}

/// Vertices of the triangles reached from the seeds without crossing the walls.
std::vector<int> flood(const Layout::Region& region, const HalfMesh& half,
                       const std::map<Edge, std::vector<int>>& triangles_at) {
  std::vector<bool> reached(half.triangles.size(), false);
  std::vector<int> front;
  for (const auto& seed : region.seeds) front.push_back(find_triangle(half, seed));
  std::set<int> vertices;
  while (!front.empty()) {
    const int t = front.back();
    front.pop_back();
    if (reached[t]) continue;
    reached[t] = true;
    for (int k = 0; k < 3; ++k) {
      const int a = half.triangles[t][k], b = half.triangles[t][(k + 1) % 3];
      vertices.insert(a);
      const Edge edge = std::minmax(a, b);
      const auto curve = half.curve_edges.find(edge);
      if (curve != half.curve_edges.end() &&
          std::find(region.walls.begin(), region.walls.end(), curve->second) != region.walls.end()) {
        continue;
      }
      for (const int next : triangles_at.at(edge)) front.push_back(next);
    }
  }
  return {vertices.begin(), vertices.end()};
}

class Annotator {
 public:
  Annotator(const Layout& layout, const HalfMesh& half, const SurfaceLookup& surface, ControlMesh& mesh)
      : layout_(layout), half_(half), surface_(surface), mesh_(mesh) {}

  void run() {
    add_regions();
    add_landmarks();
    add_boxes();
    for (const auto& [a, b] : layout_.bindings) bind(a, b);
    auto& bindings = mesh_.annotations.binding_edges;
    std::sort(bindings.begin(), bindings.end());
    bindings.erase(std::unique(bindings.begin(), bindings.end()), bindings.end());
    constrain();
    mesh_.annotations.clipping_planes = layout_.planes;
  }

 private:
  int image(int v) const { return mesh_.annotations.mirror[v]; }

  std::vector<int> images(const std::vector<int>& vertices) const {
    std::vector<int> result;
    for (const int v : vertices) result.push_back(image(v));
    std::sort(result.begin(), result.end());
    return result;
  }

  static std::vector<int> join(const std::vector<int>& a, const std::vector<int>& b) {
    std::vector<int> both;
    std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
    return both;
  }

  void add_regions() {
    std::map<Edge, std::vector<int>> triangles_at;
    for (int t = 0; t < static_cast<int>(half_.triangles.size()); ++t) {
      for (int k = 0; k < 3; ++k) {
        triangles_at[std::minmax(half_.triangles[t][k], half_.triangles[t][(k + 1) % 3])].push_back(t);
      }
    }
    auto& regions = mesh_.annotations.regions;
    for (const auto& region : layout_.regions) {
      std::vector<int> right = flood(region, half_, triangles_at);
      std::vector<int> left = images(right);
      for (const auto& name : region.including) {
        right = join(right, regions.at(name));
        left = join(left, images(regions.at(name)));
      }
      if (region.right == region.left) {
        regions[region.right] = join(right, left);
      } else {
        if (std::any_of(right.begin(), right.end(), [&](int v) { return image(v) == v; })) {
          throw InvalidInput("region '" + region.right + "' (line " + std::to_string(region.line) +
                             ") reaches the mirror line: its curves do not close it off");
        }
        regions[region.right] = right;
        regions[region.left] = left;
      }
    }
  }

  void add_landmarks() {
    std::vector<Eigen::Vector3f> points;
    for (const auto& p : mesh_.positions) points.push_back(p.cast<float>());
    const SurfaceIndex index(points, mesh_.triangles);
    const auto nearest = [&](const Eigen::Vector3d& place, const std::string& name) {
      const auto hit = index.find_nearest(place, std::numeric_limits<double>::infinity());
      if (!hit) throw InvalidInput("landmark '" + name + "' is nowhere on the mesh");
      return SurfacePoint{hit->triangle_idx, tidy_weights(hit->weights)};
    };
    for (const auto& mark : layout_.landmarks) {
      Eigen::Vector3d place = surface_.position(mark.uv);
      if (mark.uv[0] == 0.5) place[0] = 0;
      mesh_.annotations.landmarks[mark.right] = nearest(place, mark.right);
      if (mark.left == mark.right) {
        if (mark.uv[0] == 0.5) put_on_mirror_line(mesh_.annotations.landmarks[mark.right]);
        continue;
      }
      // The mirror image in the image of the triangle, corner for corner.
      const SurfacePoint& right = mesh_.annotations.landmarks[mark.right];
      mesh_.annotations.landmarks[mark.left] = mirror_point(right);
    }
  }

  /// Leaves weight only to corners that are their own mirror image, if there are any.
  void put_on_mirror_line(SurfacePoint& point) const {
    Eigen::Vector3d weights = point.weights;
    for (int k = 0; k < 3; ++k) {
      const int v = mesh_.triangles[point.triangle_idx][k];
      if (image(v) != v) weights[k] = 0;
    }
    if (weights.sum() > 0) point.weights = tidy_weights(weights);
  }

  SurfacePoint mirror_point(const SurfacePoint& point) const {
    const auto& tri = mesh_.triangles[point.triangle_idx];
    const std::array<int, 3> wanted = {image(tri[0]), image(tri[1]), image(tri[2])};
    for (int t = 0; t < static_cast<int>(mesh_.triangles.size()); ++t) {
      SurfacePoint result{t, Eigen::Vector3d::Zero()};
      int found = 0;
      for (int k = 0; k < 3; ++k) {
        for (int j = 0; j < 3; ++j) {
          if (mesh_.triangles[t][k] == wanted[j]) result.weights[k] = point.weights[j], ++found;
        }
      }
      if (found == 3) return result;
    }
    throw ContractViolation("a triangle without mirror image");
  }

  void add_boxes() {
    for (const auto& box : layout_.boxes) {
      Eigen::AlignedBox3d right;
      for (const int v : mesh_.annotations.regions.at(box.region)) right.extend(mesh_.positions[v]);
      if (right.isEmpty())
        throw InvalidInput("box '" + box.right + "' (line " + std::to_string(box.line) + "): region '" +
                           box.region + "' is empty");
      right.min().array() -= box.pad_mm;
      right.max().array() += box.pad_mm;
      mesh_.annotations.boxes[box.right] = right;
      if (box.left == box.right) continue;
      Eigen::AlignedBox3d left = right;
      left.min()[0] = -right.max()[0];
      left.max()[0] = -right.min()[0];
      mesh_.annotations.boxes[box.left] = left;
    }
  }

  void bind(int a, int b) {
    auto& bindings = mesh_.annotations.binding_edges;
    bindings.push_back(std::minmax(a, b));
    bindings.push_back(std::minmax(image(a), image(b)));
  }

  /// Vertices of the named regions that are not on the regions' own curves, and those of the named curves.
  void constrain() {
    std::set<int> inside;
    for (const auto& [edge, curve] : half_.curve_edges) {
      const auto& names = layout_.constrained_curves;
      if (curve < 0 || std::find(names.begin(), names.end(), layout_.curves[curve].name) == names.end())
        continue;
      for (const int v : {edge.first, edge.second}) inside.insert(v), inside.insert(image(v));
    }
    for (const auto& name : layout_.constrained_regions) {
      const auto region = std::find_if(layout_.regions.begin(), layout_.regions.end(),
                                       [&](const auto& r) { return r.right == name; });
      if (region == layout_.regions.end()) continue;
      std::set<int> on_walls;
      for (const auto& [edge, curve] : half_.curve_edges) {
        if (std::find(region->walls.begin(), region->walls.end(), curve) == region->walls.end()) continue;
        for (const int v : {edge.first, edge.second}) on_walls.insert(v), on_walls.insert(image(v));
      }
      for (const int v : mesh_.annotations.regions.at(name)) {
        if (!on_walls.count(v)) inside.insert(v);
      }
    }
    mesh_.annotations.constrained_vertices.assign(inside.begin(), inside.end());
  }

  const Layout& layout_;
  const HalfMesh& half_;
  const SurfaceLookup& surface_;
  ControlMesh& mesh_;
};

}  // namespace

ControlMesh unfold(const HalfMesh& half, const std::vector<Eigen::Vector3d>& positions) {
  ControlMesh mesh;
  const int n = static_cast<int>(half.vertices.size());
  auto& mirror = mesh.annotations.mirror;
  mirror.resize(n);
  for (int v = 0; v < n; ++v) {
    mesh.positions.push_back(positions[v].unaryExpr(&on_grain));
    mesh.uv.push_back(half.vertices[v].uv.unaryExpr(&on_grain));
    if (half.vertices[v].on_mirror()) mesh.positions[v][0] = 0, mirror[v] = v;
  }
  for (int v = 0; v < n; ++v) {
    if (half.vertices[v].on_mirror()) continue;
    mirror[v] = static_cast<int>(mesh.positions.size());
    mirror.push_back(v);
    const Eigen::Vector3d p = mesh.positions[v];
    mesh.positions.push_back({-p[0], p[1], p[2]});
    mesh.uv.push_back({on_grain(1 - mesh.uv[v][0]), mesh.uv[v][1]});
  }
  mesh.triangles = half.triangles;
  for (const auto& t : half.triangles) mesh.triangles.push_back({mirror[t[0]], mirror[t[2]], mirror[t[1]]});
  return mesh;
}

void annotate(const Layout& layout, const HalfMesh& half, const SurfaceLookup& surface, ControlMesh& mesh) {
  Annotator(layout, half, surface, mesh).run();
}

}  // namespace phiz
