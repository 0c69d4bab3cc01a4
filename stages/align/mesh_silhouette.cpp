#include "stages/align/mesh_silhouette.h"

#include <algorithm>
#include <string>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

// Views in the order of ViewAxis: which axis of space runs along columns and rows, and the sign of each axis
// in pictures.
constexpr std::array<std::size_t, 3> kColumns = {0, 2, 0}, kRows = {1, 1, 2};
const Eigen::Vector3d kPictureSigns(1, -1, 1);

struct DirectedEdge {
  std::int32_t low, high, triangle;
  bool upward;  ///< the triangle runs from low to high
};

// fixed = round(coefficients . (x, y, z, 1)), within reach; what is not a number goes to the lower end.
void project_coordinate(const std::vector<double>& x, const std::vector<double>& y,
                        const std::vector<double>& z, const Eigen::RowVector4d& coefficients,
                        std::vector<std::int32_t>& fixed) {
  constexpr double kReach = ContourScan::kReach;
  constexpr std::int32_t kBias = 2 * ContourScan::kReach;
  const double a = coefficients[0], b = coefficients[1], c = coefficients[2], d = coefficients[3];
  const std::size_t count = x.size();
  fixed.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    double value = a * x[i] + b * y[i] + c * z[i] + d;
    value = value > -kReach ? value : -kReach;
    value = value < kReach ? value : kReach;
    fixed[i] = static_cast<std::int32_t>(value + (kBias + 0.5)) - kBias;
  }
}

void prepare(int size, Silhouette& out) {
  if (out.width() != size || out.height() != size) {
    out = Silhouette(size);
  } else {
    out.clear();
  }
}

}  // namespace

SilhouetteMesh::SilhouetteMesh(std::span<const Eigen::Vector3f> positions,
                               std::span<const Eigen::Vector3i> triangles) {
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!positions[i].allFinite())
      throw InvalidInput("position of vertex " + std::to_string(i) + " is not finite");
    x_.push_back(positions[i].x()), y_.push_back(positions[i].y()), z_.push_back(positions[i].z());
  }
  std::vector<DirectedEdge> edges;
  edges.reserve(triangles.size() * 3);
  for (const Eigen::Vector3i& t : triangles) {
    const auto triangle_idx = static_cast<std::int32_t>(triangles_.size());
    if (t.minCoeff() < 0 || t.maxCoeff() >= vertex_count())
      throw InvalidInput("triangle " + std::to_string(triangle_idx) + " has a vertex index out of range");
    triangles_.push_back({t.x(), t.y(), t.z()});
    for (int k = 0; k < 3; ++k) {
      const std::int32_t from = t[k], to = t[(k + 1) % 3];
      edges.push_back({std::min(from, to), std::max(from, to), triangle_idx, from < to});
    }
  }
  std::stable_sort(edges.begin(), edges.end(), [](const DirectedEdge& a, const DirectedEdge& b) {
    return a.low != b.low ? a.low < b.low : a.high < b.high;
  });
  // Opposite half-edges of one edge are matched in pairs; what is left over is border.
  for (std::size_t begin = 0, end; begin < edges.size(); begin = end) {
    std::vector<std::int32_t> upward, downward;
    for (end = begin;
         end < edges.size() && edges[end].low == edges[begin].low && edges[end].high == edges[begin].high;
         ++end)
      (edges[end].upward ? upward : downward).push_back(edges[end].triangle);
    const std::int32_t low = edges[begin].low, high = edges[begin].high;
    const std::size_t pairs = std::min(upward.size(), downward.size());
    for (std::size_t k = 0; k < pairs; ++k) inner_.push_back({low, high, upward[k], downward[k]});
    for (std::size_t k = pairs; k < upward.size(); ++k) border_.push_back({low, high, upward[k]});
    for (std::size_t k = pairs; k < downward.size(); ++k) border_.push_back({high, low, downward[k]});
  }
}

// All views share their coordinates: one row of the affine map for each axis of space.
void SilhouetteRasteriser::project(const SilhouetteMesh& mesh, const AffineMatrix& frame_from_model,
                                   const SilhouetteFrame& frame) {
  const Eigen::Vector3d scale = kPictureSigns * (ContourScan::kSub / frame.mm_per_pixel);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = static_cast<Eigen::Index>(k);
    Eigen::RowVector4d coefficients = frame_from_model.row(axis) * scale[axis];
    coefficients[3] += 0.5 * frame.size * ContourScan::kSub - frame.centre_mm[axis] * scale[axis];
    project_coordinate(mesh.x_, mesh.y_, mesh.z_, coefficients, coordinates_[k]);
  }
  corners_.resize(coordinates_[0].size());
  for (std::size_t i = 0; i < corners_.size(); ++i)
    corners_[i] = {coordinates_[0][i], coordinates_[1][i], coordinates_[2][i]};
}

void SilhouetteRasteriser::find_facing(const SilhouetteMesh& mesh) {
  front_.resize(mesh.triangles_.size());
  for (std::size_t t = 0; t < front_.size(); ++t) {
    const Corner& a = corners_[static_cast<std::size_t>(mesh.triangles_[t][0])];
    const Corner& b = corners_[static_cast<std::size_t>(mesh.triangles_[t][1])];
    const Corner& c = corners_[static_cast<std::size_t>(mesh.triangles_[t][2])];
    const std::int64_t ux = b[0] - a[0], uy = b[1] - a[1], uz = b[2] - a[2];
    const std::int64_t vx = c[0] - a[0], vy = c[1] - a[1], vz = c[2] - a[2];
    const unsigned front = ux * vy > uy * vx, side = uz * vy > uy * vz, top = ux * vz > uz * vx;
    front_[t] = static_cast<std::uint8_t>(front | side << 1 | top << 2);
  }
}

void SilhouetteRasteriser::collect_contours(const SilhouetteMesh& mesh, unsigned views) {
  using Counter = ContourScan::Counter;
  const auto add = [&](unsigned view, std::int32_t from, std::int32_t to, Counter counter) {
    const Corner& p = corners_[static_cast<std::size_t>(from)];
    const Corner& q = corners_[static_cast<std::size_t>(to)];
    const std::size_t column = kColumns[view], row = kRows[view];
    scans_[view].add_edge(p[column], p[row], q[column], q[row], counter);
  };
  for (const SilhouetteMesh::InnerEdge& edge : mesh.inner_) {
    const unsigned left = front_[static_cast<std::size_t>(edge.left)];
    const unsigned contour = (left ^ front_[static_cast<std::size_t>(edge.right)]) & views;
    if (contour == 0) continue;
    for (unsigned view = 0; view < 3; ++view) {
      if (!(contour >> view & 1)) continue;
      left >> view & 1 ? add(view, edge.from, edge.to, Counter::kBoth)
                       : add(view, edge.to, edge.from, Counter::kBoth);
    }
  }
  for (const SilhouetteMesh::BorderEdge& edge : mesh.border_) {
    const unsigned front = front_[static_cast<std::size_t>(edge.triangle)];
    for (unsigned view = 0; view < 3; ++view) {
      if (!(views >> view & 1)) continue;
      front >> view & 1 ? add(view, edge.from, edge.to, Counter::kFirst)
                        : add(view, edge.to, edge.from, Counter::kSecond);
    }
  }
}

void SilhouetteRasteriser::rasterise(const SilhouetteMesh& mesh, const AffineMatrix& frame_from_model,
                                     ViewAxis axis, const SilhouetteFrame& frame, Silhouette& out) {
  const auto view = static_cast<unsigned>(axis);
  prepare(frame.size, out);
  project(mesh, frame_from_model, frame);
  find_facing(mesh);
  scans_[view].begin(frame.size);
  collect_contours(mesh, 1U << view);
  scans_[view].fill(out);
}

void SilhouetteRasteriser::rasterise(const SilhouetteMesh& mesh, const AffineMatrix& frame_from_model,
                                     const SilhouetteFrame& frame, std::array<Silhouette, 3>& out) {
  project(mesh, frame_from_model, frame);
  find_facing(mesh);
  for (ContourScan& scan : scans_) scan.begin(frame.size);
  collect_contours(mesh, 7);
  for (std::size_t view = 0; view < 3; ++view) {
    prepare(frame.size, out[view]);
    scans_[view].fill(out[view]);
  }
}

}  // namespace phiz
