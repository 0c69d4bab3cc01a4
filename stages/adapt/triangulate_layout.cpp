#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>

#include "stages/adapt/base_mesh.h"
#include "stages/geometry/error.h"

namespace phiz {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<int, Kernel>;
using FaceBase = CGAL::Constrained_triangulation_face_base_2<Kernel>;
using Structure = CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>;
using Triangulation =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, Structure, CGAL::No_constraint_intersection_tag>;

void require_corners(const BaseLayout& layout) {
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
    if (std::find(layout.uv.begin(), layout.uv.end(), corner) == layout.uv.end())
      throw InvalidInput("the base has no point at the corner (" +
                         std::to_string(static_cast<int>(corner.x())) + ", " +
                         std::to_string(static_cast<int>(corner.y())) + ") of the (u,v) square");
  }
}

}  // namespace

std::vector<Eigen::Vector3i> triangulate_layout(const BaseLayout& layout) {
  require_corners(layout);
  Triangulation triangulation;
  std::vector<Triangulation::Vertex_handle> handles;
  for (std::size_t i = 0; i < layout.uv.size(); ++i) {
    handles.push_back(triangulation.insert(Kernel::Point_2(layout.uv[i].x(), layout.uv[i].y())));
    if (triangulation.number_of_vertices() != i + 1)
      throw InvalidInput("'" + layout.names[i] + "' lies where another point of the base is");
    handles.back()->info() = static_cast<int>(i);
  }
  for (const auto& [a, b] : layout.edges) {
    try {
      triangulation.insert_constraint(handles[a], handles[b]);
    } catch (const Triangulation::Intersection_of_constraints_exception&) {
      throw InvalidInput("the edge '" + layout.names[a] + "' - '" + layout.names[b] +
                         "' of the base crosses another one");
    }
  }
  std::vector<Eigen::Vector3i> triangles;
  for (const auto& face : triangulation.finite_face_handles()) {
    Eigen::Vector3i t;
    for (int i = 0; i < 3; ++i) t[i] = face->vertex(i)->info();
    while (t[0] != t.minCoeff()) t = Eigen::Vector3i(t[1], t[2], t[0]);
    triangles.push_back(t);
  }
  std::sort(triangles.begin(), triangles.end(), [](const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  });
  return triangles;
}

}  // namespace phiz
