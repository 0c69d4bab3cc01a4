#include "formats/control_mesh.h"

#include <algorithm>
#include <cmath>

#include "formats/control_mesh_parts.h"
#include "formats/error.h"
#include "formats/text.h"

namespace phiz {
namespace {

constexpr double kRounding = 1e-5;  // of weights and unit vectors that went through six decimals
constexpr double kLargestMm = 1e6;  // more is no head, and six decimals would overrun

bool is_sane(const auto& vector) {
  return vector.allFinite() && vector.cwiseAbs().maxCoeff() <= kLargestMm;
}

void check_index(int idx, std::size_t count, const std::string& place) {
  if (idx < 0 || static_cast<std::size_t>(idx) >= count) {
    throw FormatError("index " + std::to_string(idx) + " is not below " + std::to_string(count) + " (" +
                      place + ")");
  }
}

void check_ascending(const std::vector<int>& indices, std::size_t count, const std::string& place) {
  for (std::size_t i = 0; i < indices.size(); ++i) {
    check_index(indices[i], count, place + "[" + std::to_string(i) + "]");
    if (i > 0 && indices[i] <= indices[i - 1]) throw FormatError("indices do not ascend (" + place + ")");
  }
}

void check_name(const std::string& name, const std::string& place) {
  const bool good = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.';
  });
  if (!good) throw FormatError("names have only letters, digits, '_', '-' and '.' (" + place + ")");
}

void check_surface(const ControlMesh& mesh) {
  if (mesh.positions.empty()) throw FormatError("no vertices");
  if (mesh.uv.size() != mesh.positions.size()) {
    throw FormatError(std::to_string(mesh.positions.size()) + " vertices but " +
                      std::to_string(mesh.uv.size()) + " (u,v)");
  }
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const std::string place = " (vertex " + std::to_string(i) + ")";
    if (!is_sane(mesh.positions[i])) throw FormatError("position is not finite or beyond 1 km" + place);
    const Eigen::Vector2d& uv = mesh.uv[i];
    if (!(uv.minCoeff() >= 0.0 && uv.maxCoeff() <= 1.0)) throw FormatError("(u,v) is not in [0,1]" + place);
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3i& corners = mesh.triangles[t];
    const std::string place = "triangle " + std::to_string(t);
    for (int corner : corners) check_index(corner, mesh.positions.size(), place);
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) {
      throw FormatError("a vertex is repeated (" + place + ")");
    }
  }
}

void check_mirror(const std::vector<int>& mirror, std::size_t vertex_count) {
  if (mirror.empty()) return;
  if (mirror.size() != vertex_count) {
    throw FormatError(std::to_string(mirror.size()) + " entries for " + std::to_string(vertex_count) +
                      " vertices (mirror)");
  }
  for (std::size_t i = 0; i < mirror.size(); ++i) {
    const std::string place = "mirror[" + std::to_string(i) + "]";
    check_index(mirror[i], vertex_count, place);
    if (mirror[static_cast<std::size_t>(mirror[i])] != static_cast<int>(i)) {
      throw FormatError("is not the mirror image of its mirror image (" + place + ")");
    }
  }
}

void check_annotations(const Annotations& annotations, std::size_t vertex_count, std::size_t triangle_count) {
  for (const auto& [name, box] : annotations.boxes) {
    check_name(name, "boxes");
    if (!is_sane(box.min()) || !is_sane(box.max()) || (box.min().array() > box.max().array()).any()) {
      throw FormatError("min is above max or not finite (boxes." + name + ")");
    }
  }
  for (const auto& [name, point] : annotations.landmarks) {
    check_name(name, "landmarks");
    check_index(point.triangle_idx, triangle_count, "landmarks." + name + ".triangle");
    const Eigen::Vector3d& w = point.weights;
    if (!w.allFinite() || w.minCoeff() < 0.0 || w.maxCoeff() > 1.0 || std::abs(w.sum() - 1.0) > kRounding) {
      throw FormatError("weights are not in [0,1] with sum 1 (landmarks." + name + ".weights)");
    }
  }
  for (const auto& [name, vertices] : annotations.regions) {
    check_name(name, "regions");
    check_ascending(vertices, vertex_count, "regions." + name);
  }
  for (std::size_t i = 0; i < annotations.binding_edges.size(); ++i) {
    const auto& [a, b] = annotations.binding_edges[i];
    const std::string place = "binding_edges[" + std::to_string(i) + "]";
    check_index(a, vertex_count, place);
    check_index(b, vertex_count, place);
    if (a == b) throw FormatError("binds a vertex to itself (" + place + ")");
  }
  check_ascending(annotations.constrained_vertices, vertex_count, "constrained_vertices");
  for (const auto& [name, plane] : annotations.clipping_planes) {
    check_name(name, "clipping_planes");
    const bool unit = plane.normal.allFinite() && std::abs(plane.normal.norm() - 1.0) <= kRounding;
    if (!unit) throw FormatError("normal is not of length 1 (clipping_planes." + name + ".normal)");
    if (!(std::abs(plane.offset_mm) <= kLargestMm)) {
      throw FormatError("is not finite or beyond 1 km (clipping_planes." + name + ".offset_mm)");
    }
  }
  check_mirror(annotations.mirror, vertex_count);
}

void check(const ControlMesh& mesh) {
  check_surface(mesh);
  check_annotations(mesh.annotations, mesh.positions.size(), mesh.triangles.size());
}

}  // namespace

ControlMesh read_control_mesh(std::istream& obj, std::istream& json) {
  ControlMesh mesh = control_mesh_parts::parse_obj(read_all(obj));
  const std::string text = read_all(json);
  try {
    mesh.annotations = control_mesh_parts::parse_json(text);
  } catch (const FormatError& error) {
    throw FormatError("its annotations, in the .json: " + std::string(error.what()), error.hint());
  }
  check(mesh);
  return mesh;
}

void write_control_mesh(const ControlMesh& mesh, std::ostream& obj, std::ostream& json) {
  check(mesh);
  write_all(obj, control_mesh_parts::format_obj(mesh));
  write_all(json, control_mesh_parts::format_json(mesh.annotations));
}

Eigen::Vector3d position_at(const SurfacePoint& point, const std::vector<Eigen::Vector3i>& triangles,
                            const std::vector<Eigen::Vector3d>& positions) {
  const Eigen::Vector3i& corners = triangles[static_cast<std::size_t>(point.triangle_idx)];
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) position += point.weights[k] * positions[static_cast<std::size_t>(corners[k])];
  return position;
}

}  // namespace phiz
