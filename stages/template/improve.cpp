#include "stages/template/improve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMinArea = 1e-9;  ///< of triangles in the square, doubled
constexpr double kPi = 3.14159265358979323846;
constexpr double kRailEnd = 0.1;  ///< share of a rail that a vertex keeps from its neighbours

double doubled_area(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

double min_angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const std::array<const Eigen::Vector3d*, 3> p = {&a, &b, &c};
  double smallest = kPi;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d u = *p[(k + 1) % 3] - *p[k], v = *p[(k + 2) % 3] - *p[k];
    smallest = std::min(smallest, std::atan2(u.cross(v).norm(), u.dot(v)));
  }
  return smallest;
}

/// Rises steeply below 26 degrees.
double angle_cost(double angle) {
  return -3 * angle + (angle < 0.45 ? 8 * (0.45 - angle) : 0);
}

/// By how much a valence in the half mesh means one below 4 or above 8 in the whole one.
int valence_excess(const HalfMesh::Vertex& vertex, int valence) {
  if (vertex.on_neck()) return 0;
  const int whole = vertex.on_mirror() ? 2 * valence - 2 : valence;
  return std::max({0, whole - 8, 4 - whole});
}

class Flipper {
 public:
  Flipper(HalfMesh& mesh, const SurfaceLookup& surface, const FlipOptions& options)
      : mesh_(mesh), surface_(surface), options_(options), positions_(lift(mesh, surface)) {
    valence_.assign(mesh.vertices.size(), 0);
    for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) enter(t);
    for (const auto& [edge, t] : opposite_) {
      if (edge.first < edge.second || !opposite_.count({edge.second, edge.first})) {
        ++valence_[edge.first], ++valence_[edge.second];
      }
    }
  }

  int run() {
    int total = 0;
    for (int round = 0; round < options_.max_rounds; ++round) {
      std::vector<std::pair<int, int>> edges;
      for (const auto& [edge, t] : opposite_) {
        if (edge.first < edge.second) edges.push_back(edge);
      }
      int flips = 0;
      for (const auto& [a, b] : edges) flips += try_flip(a, b);
      total += flips;
      if (flips == 0) break;
    }
    return total;
  }

 private:
  void enter(int t) {
    const auto& tri = mesh_.triangles[t];
    for (int k = 0; k < 3; ++k) opposite_[{tri[k], tri[(k + 1) % 3]}] = t;
  }
  void leave(int t) {
    const auto& tri = mesh_.triangles[t];
    for (int k = 0; k < 3; ++k) opposite_.erase({tri[k], tri[(k + 1) % 3]});
  }
  int apex(int t, int a, int b) const {
    for (int k = 0; k < 3; ++k) {
      const int v = mesh_.triangles[t][k];
      if (v != a && v != b) return v;
    }
    throw ContractViolation("a triangle without an apex");
  }

  double valence_cost(int v, int change) const {
    const auto& vertex = mesh_.vertices[v];
    const int regular = vertex.on_neck() || vertex.on_mirror() ? 4 : 6;
    const double off =
        (vertex.on_mirror() ? 2.0 : 1.0) * (valence_[v] + change - regular);  // of the whole mesh
    if (options_.bounds_weight == 0) return off * off;
    const double excess = valence_excess(vertex, valence_[v] + change);
    return off * off + options_.bounds_weight * excess * excess;
  }
  double chord_cost(int a, int b) {
    const auto [found, is_new] = chords_.insert({std::minmax(a, b), 0.0});
    if (is_new) {
      const Eigen::Vector3d middle = 0.5 * (positions_[a] + positions_[b]);
      const Eigen::Vector2d uv = 0.5 * (mesh_.vertices[a].uv + mesh_.vertices[b].uv);
      found->second =
          std::min(2.0, 3 * (surface_.position(uv) - middle).norm() / (positions_[a] - positions_[b]).norm());
    }
    return found->second;
  }
  double angle_of(int a, int b, int c) const {
    return min_angle(positions_[a], positions_[b], positions_[c]);
  }

  int try_flip(int a, int b) {
    const auto first = opposite_.find({a, b}), second = opposite_.find({b, a});
    if (first == opposite_.end() || second == opposite_.end()) return 0;
    if (mesh_.curve_edges.count({a, b})) return 0;
    const int t1 = first->second, t2 = second->second;
    const int c = apex(t1, a, b), d = apex(t2, a, b);
    if (opposite_.count({c, d}) || opposite_.count({d, c})) return 0;
    const auto& v = mesh_.vertices;
    if (doubled_area(v[c].uv, v[a].uv, v[d].uv) <= kMinArea) return 0;
    if (doubled_area(v[d].uv, v[b].uv, v[c].uv) <= kMinArea) return 0;
    double before = options_.chord_weight * chord_cost(a, b),
           after = options_.chord_weight * chord_cost(c, d);
    for (const int w : {a, b, c, d}) {
      before += options_.valence_weight * valence_cost(w, 0);
      after += options_.valence_weight * valence_cost(w, w == a || w == b ? -1 : 1);
    }
    before += angle_cost(std::min(angle_of(a, b, c), angle_of(b, a, d)));
    after += angle_cost(std::min(angle_of(c, a, d), angle_of(d, b, c)));
    if (!(after < before - 1e-6)) return 0;
    leave(t1), leave(t2);
    mesh_.triangles[t1] = {c, a, d};
    mesh_.triangles[t2] = {d, b, c};
    enter(t1), enter(t2);
    --valence_[a], --valence_[b], ++valence_[c], ++valence_[d];
    return 1;
  }

  HalfMesh& mesh_;
  const SurfaceLookup& surface_;
  const FlipOptions& options_;
  std::vector<Eigen::Vector3d> positions_;
  std::vector<int> valence_;
  std::map<std::pair<int, int>, int> opposite_;  ///< directed edge -> triangle
  std::map<std::pair<int, int>, double> chords_;
};

/// Gauss-Seidel descent, vertex by vertex.
class Relaxer {
 public:
  Relaxer(HalfMesh& mesh, const SurfaceLookup& surface) : mesh_(mesh), surface_(surface) {
    around_.resize(mesh.vertices.size());
    for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
      for (int k = 0; k < 3; ++k) around_[mesh.triangles[t][k]].push_back(t);
    }
    positions_ = lift(mesh, surface);
  }

  void sweep() {
    for (int v = 0; v < static_cast<int>(mesh_.vertices.size()); ++v) {
      if (mesh_.vertices[v].rail)
        slide(v);
      else if (!mesh_.vertices[v].held && !mesh_.vertices[v].on_neck())
        move(v);
    }
  }

 private:
  /// Cost of the triangles around v if it were at uv; infinite where one folds.
  double cost(int v, const Eigen::Vector2d& uv, const Eigen::Vector3d& p,
              const Eigen::Vector3d& normal) const {
    double sum = 0;
    for (const int t : around_[v]) {
      const auto& tri = mesh_.triangles[t];
      int k = 0;
      while (tri[k] != v) ++k;
      const int b = tri[(k + 1) % 3], c = tri[(k + 2) % 3];
      if (doubled_area(uv, mesh_.vertices[b].uv, mesh_.vertices[c].uv) <= kMinArea) return kInfinity;
      const Eigen::Vector3d e1 = positions_[b] - p, e2 = positions_[c] - p,
                            e3 = positions_[c] - positions_[b];
      const Eigen::Vector3d cross = e1.cross(e2);
      const double area2 = cross.norm();
      if (cross.dot(normal) <= -0.5 * area2 || area2 < 1e-9) return kInfinity;
      const double ratio =
          (e1.squaredNorm() + e2.squaredNorm() + e3.squaredNorm()) / (2 * std::sqrt(3.0) * area2);
      sum += std::pow(ratio, 6);
    }
    return sum;
  }

  /// Along the vertex's rail, off its ends.
  void slide(int v) {
    auto& vertex = mesh_.vertices[v];
    const auto cost_at = [&](double t, Eigen::Vector2d& uv) {
      uv = surface_.descend_to(vertex.rail->at(t), vertex.uv);
      const auto place = surface_.find(uv);
      return cost(v, uv, surface_.position(place), surface_.normal(place));
    };
    Eigen::Vector2d uv;
    double best = cost_at(vertex.rail->parameter, uv);
    for (const double step : {0.08, -0.08, 0.02, -0.02, 0.005, -0.005}) {
      const double t = std::clamp(vertex.rail->parameter + step, kRailEnd, 1 - kRailEnd);
      const double there = cost_at(t, uv);
      if (there < best) best = there, vertex.rail->parameter = t, vertex.uv = uv;
    }
    positions_[v] = surface_.position(vertex.uv);
  }

  void move(int v) {
    auto& vertex = mesh_.vertices[v];
    const auto place = surface_.find(vertex.uv);
    const Eigen::Vector3d normal = surface_.normal(place);
    const double now = cost(v, vertex.uv, positions_[v], normal);
    if (!std::isfinite(now) && !vertex.on_mirror()) {  // folded: to the middle of its neighbours
      Eigen::Vector2d middle = Eigen::Vector2d::Zero();
      for (const int t : around_[v]) {
        for (int k = 0; k < 3; ++k) middle += mesh_.vertices[mesh_.triangles[t][k]].uv - vertex.uv;
      }
      vertex.uv += middle / (2.0 * static_cast<double>(around_[v].size()));
      positions_[v] = surface_.position(vertex.uv);
      return;
    }
    double edge = 0;
    for (const int t : around_[v]) {
      for (int k = 0; k < 3; ++k) edge += (positions_[mesh_.triangles[t][k]] - positions_[v]).norm();
    }
    edge /= 2.0 * static_cast<double>(around_[v].size());
    // Two directions of unit speed on the surface, as steps in (u,v).
    const Eigen::Matrix<double, 3, 2> jacobian = surface_.jacobian(place);
    const Eigen::Matrix2d metric = jacobian.transpose() * jacobian;
    Eigen::Matrix2d to_uv = Eigen::LLT<Eigen::Matrix2d>(metric).matrixU().solve(Eigen::Matrix2d::Identity());
    if (vertex.on_mirror())
      to_uv = Eigen::Vector2d(0, 1 / std::sqrt(metric(1, 1))) * Eigen::RowVector2d(1, 0);
    const auto at = [&](const Eigen::Vector2d& step, Eigen::Vector2d& uv, Eigen::Vector3d& p) {
      uv = vertex.uv + to_uv * step;
      if (uv[0] <= 0 || uv[1] <= 0 || uv[1] >= 1 || uv[0] > 0.5 || (uv[0] == 0.5) != vertex.on_mirror()) {
        return kInfinity;
      }
      const auto there = surface_.find(uv);
      p = surface_.position(there);
      return cost(v, uv, p, surface_.normal(there));
    };
    Eigen::Vector2d uv;
    Eigen::Vector3d p = positions_[v];
    const double h = 0.02 * edge;
    Eigen::Vector2d gradient;
    for (int k = 0; k < 2; ++k) {
      const double plus = at(h * Eigen::Vector2d::Unit(k), uv, p),
                   minus = at(-h * Eigen::Vector2d::Unit(k), uv, p);
      gradient[k] = std::isfinite(plus) && std::isfinite(minus) ? plus - minus
                    : std::isfinite(plus)                       ? -1.0
                    : std::isfinite(minus)                      ? 1.0
                                                                : 0.0;
    }
    if (!(gradient.norm() > 0)) return;
    const Eigen::Vector2d downhill = -gradient.normalized();
    for (double length = 0.3 * edge; length > 0.002 * edge; length *= 0.5) {
      const double there = at(length * downhill, uv, p);
      if (there < now - 1e-9) {
        vertex.uv = uv, positions_[v] = p;
        return;
      }
    }
  }

  HalfMesh& mesh_;
  const SurfaceLookup& surface_;
  std::vector<std::vector<int>> around_;
  std::vector<Eigen::Vector3d> positions_;
};

}  // namespace

std::vector<Eigen::Vector3d> lift(const HalfMesh& mesh, const SurfaceLookup& surface) {
  std::vector<Eigen::Vector3d> positions;
  for (const auto& v : mesh.vertices) {
    positions.push_back(surface.position(v.uv));
    if (v.on_mirror()) positions.back()[0] = 0;
  }
  return positions;
}

bool has_odd_valences(const HalfMesh& mesh) {
  std::set<std::pair<int, int>> edges;
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) edges.insert(std::minmax(t[k], t[(k + 1) % 3]));
  }
  std::vector<int> valences(mesh.vertices.size(), 0);
  for (const auto& [a, b] : edges) ++valences[a], ++valences[b];
  for (std::size_t v = 0; v < valences.size(); ++v) {
    if (valence_excess(mesh.vertices[v], valences[v]) > 0) return true;
  }
  return false;
}

int flip_edges(HalfMesh& mesh, const SurfaceLookup& surface, const FlipOptions& options) {
  return Flipper(mesh, surface, options).run();
}

void relax(HalfMesh& mesh, const SurfaceLookup& surface, int sweeps) {
  Relaxer relaxer(mesh, surface);
  for (int k = 0; k < sweeps; ++k) relaxer.sweep();
}

std::vector<double> min_angles_deg(const std::vector<Eigen::Vector3d>& positions,
                                   const std::vector<Eigen::Vector3i>& triangles) {
  std::vector<double> angles;
  for (const auto& t : triangles) {
    angles.push_back(min_angle(positions[t[0]], positions[t[1]], positions[t[2]]) * 180 / kPi);
  }
  return angles;
}

}  // namespace phiz
