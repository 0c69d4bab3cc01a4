#include "stages/template/average.h"

#include <Eigen/Geometry>
#include <string>

#include "stages/geometry/error.h"
#include "stages/geometry/half_edge.h"
#include "stages/template/separate.h"
#include "stages/template/tidy.h"

namespace phiz {
namespace {

Eigen::Matrix3Xd to_columns(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Matrix3Xd columns(3, static_cast<Eigen::Index>(points.size()));
  for (Eigen::Index k = 0; k < columns.cols(); ++k) columns.col(k) = points[static_cast<std::size_t>(k)];
  return columns;
}

/// Half of each vertex's change from the mean of its neighbours', round by round.
void smooth_change(const ControlMesh& mesh, Eigen::Matrix3Xd& change, int rounds) {
  const HalfEdgeMesh connectivity(mesh.triangles, static_cast<int>(mesh.positions.size()));
  for (int round = 0; round < rounds; ++round) {
    Eigen::Matrix3Xd next = change;
    for (int v = 0; v < connectivity.vertex_count(); ++v) {
      const std::vector<int> ring = connectivity.ring(v);
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (const int w : ring) sum += change.col(w);
      if (!ring.empty()) next.col(v) = 0.5 * change.col(v) + 0.5 * sum / static_cast<double>(ring.size());
    }
    change = next;
  }
}

/// The neck loop keeps its distance from the plane that cuts necks.
void keep_neck_at_plane(ControlMesh& mesh, const std::vector<Eigen::Vector3d>& before) {
  const auto plane = mesh.annotations.clipping_planes.find("neck");
  if (plane == mesh.annotations.clipping_planes.end()) return;
  const HalfEdgeMesh connectivity(mesh.triangles, static_cast<int>(mesh.positions.size()));
  const Eigen::Vector3d& normal = plane->second.normal;
  for (int v = 0; v < connectivity.vertex_count(); ++v) {
    if (connectivity.is_border_vertex(v))
      mesh.positions[v] += normal.dot(before[v] - mesh.positions[v]) * normal;
  }
}

Eigen::AlignedBox3d find_box(const std::vector<Eigen::Vector3d>& positions,
                             const std::vector<int>& vertices) {
  Eigen::AlignedBox3d box;
  for (const int v : vertices) box.extend(positions[v]);
  return box;
}

/// Every box keeps its vertices and its distance from the outermost of them.
void move_boxes(ControlMesh& mesh, const std::vector<Eigen::Vector3d>& before) {
  for (auto& [name, box] : mesh.annotations.boxes) {
    std::vector<int> vertices;
    for (int v = 0; v < static_cast<int>(before.size()); ++v) {
      if (box.contains(before[v])) vertices.push_back(v);
    }
    if (vertices.empty()) continue;
    const Eigen::AlignedBox3d was = find_box(before, vertices), is = find_box(mesh.positions, vertices);
    box.min() = (box.min() + is.min() - was.min()).unaryExpr(&on_grain).eval();
    box.max() = (box.max() + is.max() - was.max()).unaryExpr(&on_grain).eval();
  }
}

}  // namespace

ControlMesh average_heads(const ControlMesh& head, std::span<const std::vector<Eigen::Vector3d>> subjects,
                          const AverageOptions& options) {
  if (subjects.empty()) throw InvalidInput("there is no subject to average");
  if (head.annotations.mirror.size() != head.positions.size())
    throw InvalidInput("the generic head has no mirror map");
  const Eigen::Matrix3Xd target = to_columns(head.positions);
  Eigen::Matrix3Xd sum = Eigen::Matrix3Xd::Zero(3, target.cols());
  for (std::size_t k = 0; k < subjects.size(); ++k) {
    if (subjects[k].size() != head.positions.size()) {
      throw InvalidInput("subject " + std::to_string(k + 1) + " has " + std::to_string(subjects[k].size()) +
                         " vertices, the generic head has " + std::to_string(head.positions.size()));
    }
    const Eigen::Matrix3Xd source = to_columns(subjects[k]);
    const Eigen::Matrix4d target_from_source = Eigen::umeyama(source, target, false);
    sum += (target_from_source * source.colwise().homogeneous()).topRows<3>();
  }
  Eigen::Matrix3Xd change = sum / static_cast<double>(subjects.size()) - target;
  smooth_change(head, change, options.smooth_rounds);

  ControlMesh mean = head;
  for (std::size_t v = 0; v < mean.positions.size(); ++v)
    mean.positions[v] += change.col(static_cast<Eigen::Index>(v));
  keep_neck_at_plane(mean, head.positions);
  make_symmetric(mean);
  hold_back_sharp_triangles(mean, head.positions, options.min_angle_deg);
  settle(mean, options.min_angle_deg);
  move_boxes(mean, head.positions);
  return mean;
}

}  // namespace phiz
