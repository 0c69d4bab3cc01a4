#include "stages/fit/eyelids.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "stages/geometry/half_edge.h"

namespace phiz {
namespace {

constexpr int kEdgeRings = 2;     ///< from the inner loop to the edge of a lid
constexpr int kSkinRings = 6;     ///< from there to what stays
constexpr int kSmoothings = 400;  ///< of the weights between
constexpr double kUpperShare = 0.8;
constexpr int kColumns = 12;
constexpr double kCornerReach = 1.2;    ///< of the lids' edges, against the inner loop
constexpr double kLeastLidMm = 1.0;     ///< lid in front of the eye
constexpr double kPocketDepthMm = 2.5;  ///< eye behind shut lids
constexpr double kPocketFlatness = 0.1;

using Positions = Eyelids::Positions;

/// Rings round `seeds`, ring by ring; -1 beyond the last.
std::vector<int> count_rings(const HalfEdgeMesh& mesh, int vertex_count, const std::vector<int>& seeds,
                             const std::vector<char>& closed, int rings) {
  std::vector<int> ring(vertex_count, -1);
  std::vector<int> front = seeds;
  for (const int v : seeds) ring[v] = 0;
  for (int r = 1; r <= rings; ++r) {
    std::vector<int> next;
    for (const int v : front)
      for (const int n : mesh.ring(v))
        if (ring[n] < 0 && !closed[n]) ring[n] = r, next.push_back(n);
    front = std::move(next);
  }
  return ring;
}

/// Corner to corner, up and forward of an eye, by its loop.
struct EyeFrame {
  Eigen::Vector3d centre, across, up, forward;  ///< of the line from corner to corner
  double half_width = 0;

  EyeFrame(const std::vector<int>& loop, const Positions& x) {
    const auto [left, right] =
        std::minmax_element(loop.begin(), loop.end(), [&](int a, int b) { return x(a, 0) < x(b, 0); });
    const Eigen::Vector3d corner = x.row(*left).transpose(), other = x.row(*right).transpose();
    centre = (corner + other) / 2;
    across = (other - corner).normalized();
    forward = (Eigen::Vector3d::UnitZ() - across.z() * across).normalized();
    up = forward.cross(across);
    half_width = std::max(kCornerReach * (other - corner).norm() / 2, 1e-3);  // a template may be degenerate
  }

  Eigen::Vector3d into(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d d = p - centre;
    return {across.dot(d), up.dot(d), forward.dot(d)};
  }
  Eigen::Vector3d out_of(const Eigen::Vector3d& p) const {
    return centre + p.x() * across + p.y() * up + p.z() * forward;
  }
};

/// A function of the place between the corners, -1 to 1: the least or most value around each column.
class Profile {
 public:
  explicit Profile(double nothing) { values_.fill(nothing); }
  double& at(double s) {
    return values_[static_cast<int>(std::clamp(column(s) + 0.5, 0.0, double(kColumns)))];
  }
  double value(double s) const {
    const double c = std::clamp(column(s), 0.0, double(kColumns));
    const int low = std::min(static_cast<int>(c), kColumns - 1);
    return values_[low] + (c - low) * (values_[low + 1] - values_[low]);
  }
  double& operator[](int i) { return values_[i]; }
  double operator[](int i) const { return values_[i]; }

 private:
  static double column(double s) { return (s + 1) / 2 * kColumns; }
  std::array<double, kColumns + 1> values_;
};

/// The edges of both lids over the eye and where they meet when shut.
struct LidEdges {
  static constexpr double kNone = 1e9;
  Profile upper{kNone}, lower{-kNone};

  /// Columns without vertices take the nearest's; beyond the last with vertices of both lids these meet.
  void fill_gaps() {
    int first = kColumns, last = 0;
    for (int i = 0; i <= kColumns; ++i)
      if (upper[i] < kNone && lower[i] > -kNone) first = std::min(first, i), last = i;
    const LidEdges known = *this;
    for (int i = 0; i <= kColumns; ++i) {
      const int column = std::clamp(i, std::min(first, last), last);
      for (int far = 0; far <= kColumns && upper[i] >= kNone; ++far)
        for (const int near : {column - far, column + far})
          if (near >= first && near <= last && known.upper[near] < kNone) upper[i] = known.upper[near];
      for (int far = 0; far <= kColumns && lower[i] <= -kNone; ++far)
        for (const int near : {column - far, column + far})
          if (near >= first && near <= last && known.lower[near] > -kNone) lower[i] = known.lower[near];
      if (i < first || i > last) upper[i] = lower[i] = (upper[i] + lower[i]) / 2;
    }
  }
  double gap(double s) const {
    return std::abs(s) >= 1 ? 0.0 : std::max(0.0, upper.value(s) - lower.value(s));
  }
  double line(double s) const { return lower.value(s) + (1 - kUpperShare) * gap(s); }
};

}  // namespace

Eyelids::Eyelids(const ControlMesh& generic_head) {
  const int count = static_cast<int>(generic_head.positions.size());
  const auto region = generic_head.annotations.regions.find("eyes");
  if (region == generic_head.annotations.regions.end()) return;
  const HalfEdgeMesh mesh(generic_head.triangles, count);
  std::vector<char> inside(count, 0), outside(count, 1), constrained(count, 0);
  for (const int v : region->second) inside[v] = 1, outside[v] = 0;
  for (const int v : generic_head.annotations.constrained_vertices) constrained[v] = 1;
  std::vector<char> seen(count, 0);
  for (const int seed : region->second) {
    if (seen[seed]) continue;
    const std::vector<int> component = count_rings(mesh, count, {seed}, outside, count);
    Eye eye;
    for (int v = 0; v < count; ++v) {
      if (component[v] < 0) continue;
      seen[v] = 1;
      (constrained[v] ? eye.loop : eye.patch).push_back(v);
    }
    if (eye.loop.size() < 6) continue;
    const std::vector<int> ring = count_rings(mesh, count, eye.loop, inside, kEdgeRings + kSkinRings);
    std::vector<double> weight(count, 0.0);
    for (int v = 0; v < count; ++v) {
      if (ring[v] >= 0 && ring[v] < kEdgeRings + kSkinRings) eye.lids.push_back(v);
      weight[v] = ring[v] >= 0 && ring[v] <= kEdgeRings;
    }
    for (int k = 0; k < kSmoothings; ++k)
      for (const int v : eye.lids) {
        if (ring[v] <= kEdgeRings) continue;
        double sum = 0;
        const std::vector<int> around = mesh.ring(v);
        for (const int n : around) sum += weight[n];
        weight[v] = sum / static_cast<double>(around.size());
      }
    for (const int v : eye.lids) eye.weights.push_back(weight[v]);
    eye.moved = eye.lids;
    eye.moved.insert(eye.moved.end(), eye.patch.begin(), eye.patch.end());
    std::sort(eye.moved.begin(), eye.moved.end());
    eyes_.push_back(std::move(eye));
  }
}

void Eyelids::shut(int eye_idx, Positions& x) const {
  const Eye& eye = eyes_[eye_idx];
  const EyeFrame frame(eye.loop, x);
  std::vector<Eigen::Vector3d> lids, patch;
  for (const int v : eye.lids) lids.push_back(frame.into(x.row(v).transpose()));
  for (const int v : eye.patch) patch.push_back(frame.into(x.row(v).transpose()));
  LidEdges edges;
  for (std::size_t i = 0; i < lids.size(); ++i) {
    if (eye.weights[i] < 1) continue;
    const double s = lids[i].x() / frame.half_width, y = lids[i].y();
    double& edge = y > 0 ? edges.upper.at(s) : edges.lower.at(s);
    edge = y > 0 ? std::min(edge, y) : std::max(edge, y);
  }
  edges.fill_gaps();
  const auto eye_height = [&](const Eigen::Vector3d& p) {
    double sum = 0, weights = 0;
    for (const Eigen::Vector3d& q : patch) {
      const double w = 1 / (1e-3 + std::pow((q - p).head<2>().squaredNorm(), 2));
      sum += w * q.z(), weights += w;
    }
    return weights > 0 ? sum / weights : -1e9;
  };
  for (std::size_t i = 0; i < lids.size(); ++i) {
    Eigen::Vector3d p = lids[i];
    const double s = p.x() / frame.half_width, gap = edges.gap(s);
    const bool hem = eye.weights[i] == 1;
    p.y() += eye.weights[i] * (lids[i].y() > 0 ? -kUpperShare : 1 - kUpperShare) * gap;
    const double raised = eye_height(p) + kLeastLidMm;
    if (!hem && std::abs(s) < 1 && p.y() < edges.upper.value(s) && p.y() > edges.lower.value(s))
      p.z() = std::max(p.z(), raised);
    x.row(eye.lids[i]) = frame.out_of(p).transpose();
  }
  for (std::size_t i = 0; i < patch.size(); ++i) {
    Eigen::Vector3d p = patch[i];
    const double s = std::clamp(p.x() / frame.half_width, -1.0, 1.0);
    p.y() = edges.line(s) + kPocketFlatness * (p.y() - edges.line(s));
    p.z() -= kPocketDepthMm * (1 - s * s);
    x.row(eye.patch[i]) = frame.out_of(p).transpose();
  }
}

}  // namespace phiz
