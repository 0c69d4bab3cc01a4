#include "stages/template/triangulate.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<int, Kernel>;
using FaceBase = CGAL::Constrained_triangulation_face_base_2<Kernel>;
using Structure = CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>;
using Triangulation =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, Structure, CGAL::No_constraint_intersection_tag>;

std::string name_of(const Layout& layout, int point) {
  const auto& p = layout.points[point];
  std::string name = "(" + std::to_string(p.uv[0]) + ", " + std::to_string(p.uv[1]) + ")";
  if (!p.name.empty()) name = std::string("'").append(p.name).append("'");
  return name.append(" (line ").append(std::to_string(p.line)).append(")");
}

/// Points along the border of the half square, counter-clockwise from (1/2, 0), and the square's corners in
/// it.
std::vector<int> find_border(const Layout& layout) {
  std::array<std::vector<int>, 4> sides;  // top, left, bottom (as the border runs: mirror line last)
  for (int i = 0; i < static_cast<int>(layout.points.size()); ++i) {
    const auto& uv = layout.points[i].uv;
    if (uv[0] == 0.5)
      sides[0].push_back(i);
    else if (uv[1] == 1)
      sides[1].push_back(i);
    else if (uv[0] == 0)
      sides[2].push_back(i);
    else if (uv[1] == 0)
      sides[3].push_back(i);
  }
  const auto sort = [&](std::vector<int>& side, int axis, double sign) {
    std::sort(side.begin(), side.end(), [&](int a, int b) {
      return sign * layout.points[a].uv[axis] < sign * layout.points[b].uv[axis];
    });
  };
  sort(sides[0], 1, 1), sort(sides[1], 0, -1), sort(sides[2], 1, -1), sort(sides[3], 0, 1);
  std::vector<int> border;
  for (const auto& side : sides) border.insert(border.end(), side.begin(), side.end());
  const std::array<Eigen::Vector2d, 4> corners = {Eigen::Vector2d(0.5, 0), {0.5, 1}, {0, 1}, {0, 0}};
  for (const auto& corner : corners) {
    if (std::none_of(border.begin(), border.end(), [&](int i) { return layout.points[i].uv == corner; })) {
      throw InvalidInput("the layout has no point at the corner (" + std::to_string(corner[0]) + ", " +
                         std::to_string(corner[1]) + ")");
    }
  }
  return border;
}

class Builder {
 public:
  explicit Builder(const Layout& layout) : layout_(layout) {
    for (int i = 0; i < static_cast<int>(layout.points.size()); ++i) {
      const auto& p = layout.points[i];
      handles_.push_back(triangulation_.insert(Kernel::Point_2(p.uv[0], p.uv[1])));
      handles_.back()->info() = i;
    }
    const auto border = find_border(layout);
    for (std::size_t k = 0; k < border.size(); ++k)
      connect(border[k], border[(k + 1) % border.size()], kBorder);
    for (int c = 0; c < static_cast<int>(layout.curves.size()); ++c) {
      const auto& points = layout.curves[c].points;
      for (std::size_t k = 0; k + 1 < points.size(); ++k) connect(points[k], points[k + 1], c);
      if (layout.curves[c].closed) connect(points.back(), points.front(), c);
    }
    for (const auto& [a, b] : layout.edges) connect(a, b, kEdge);
  }

  HalfMesh result() {
    for (const auto& p : layout_.points) mesh_.vertices.push_back({p.uv, p.held, std::nullopt});
    for (auto f = triangulation_.finite_faces_begin(); f != triangulation_.finite_faces_end(); ++f) {
      mesh_.triangles.push_back({f->vertex(0)->info(), f->vertex(1)->info(), f->vertex(2)->info()});
    }
    // The order of CGAL's faces is its own business: ours is by vertices.
    for (auto& t : mesh_.triangles) {
      while (t[0] > t[1] || t[0] > t[2]) t = {t[1], t[2], t[0]};
    }
    std::sort(mesh_.triangles.begin(), mesh_.triangles.end(), [](const auto& a, const auto& b) {
      return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
    });
    return mesh_;
  }

 private:
  static constexpr int kEdge = -1, kBorder = -2;  ///< instead of a curve's index

  void connect(int a, int b, int curve) {
    std::string who = curve == kEdge ? "an edge" : "the border";
    if (curve >= 0) {
      who = std::string("curve '").append(layout_.curves[curve].name).append("' (line ");
      who.append(std::to_string(layout_.curves[curve].line)).append(")");
    }
    Triangulation::Face_handle face;
    int index = 0;
    const bool known =
        triangulation_.is_edge(handles_[a], handles_[b], face, index) && face->is_constrained(index);
    try {
      if (!known) triangulation_.insert_constraint(handles_[a], handles_[b]);
    } catch (const Triangulation::Intersection_of_constraints_exception&) {
      throw InvalidInput(who + " crosses another curve between " + name_of(layout_, a) + " and " +
                         name_of(layout_, b));
    }
    if (!triangulation_.is_edge(handles_[a], handles_[b], face, index)) {
      throw InvalidInput(who + " runs through another point between " + name_of(layout_, a) + " and " +
                         name_of(layout_, b));
    }
    if (curve != kBorder) mesh_.curve_edges.insert({std::minmax(a, b), curve});
  }

  const Layout& layout_;
  Triangulation triangulation_;
  std::vector<Triangulation::Vertex_handle> handles_;
  HalfMesh mesh_;
};

}  // namespace

HalfMesh triangulate_layout(const Layout& layout) {
  return Builder(layout).result();
}

}  // namespace phiz
