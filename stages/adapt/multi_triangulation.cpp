#include "stages/adapt/multi_triangulation.h"

#include <cstdlib>

#include "stages/geometry/error.h"

namespace phiz {

MultiTriangulation::MultiTriangulation(std::span<const Eigen::Vector3i> base, int vertex_count)
    : mesh_(base, vertex_count), base_vertices_(vertex_count), base_faces_(static_cast<int>(base.size())) {
  for (int f = 0; f < base_faces_; ++f) {
    const int t = mesh_.twin(StellarMesh::half_edge(f, 0));
    if (t != StellarMesh::kNone && (t & 3) != 0)
      throw InvalidInput("face " + std::to_string(f) + " of the base and its neighbour " +
                             std::to_string(StellarMesh::face(t)) + " are no block",
                         "make the base compliant first");
  }
}

int MultiTriangulation::next_split(int f) const {
  for (;;) {
    const int t = mesh_.twin(StellarMesh::half_edge(f, 0));
    if (t == StellarMesh::kNone || (t & 3) == 0) return f;
    f = StellarMesh::face(t);  // one level coarser: its own edge has to be split first
  }
}

StellarChange MultiTriangulation::split(int f) {
  const int h = StellarMesh::half_edge(f, 0), t = mesh_.twin(h), level = mesh_.face_level(f);
  CONTRACT(level < kMostLevel && (t == StellarMesh::kNone || (t & 3) == 0));
  StellarChange change;
  const std::array<int, 3> corners = mesh_.corners(f);
  change.a = corners[0], change.b = corners[1], change.c = corners[2];
  change.f = f;
  if (t != StellarMesh::kNone) {
    change.g = StellarMesh::face(t);
    change.d = mesh_.corners(change.g)[2];
  }
  const int v = change.vertex = mesh_.split_edge(h);
  mesh_.set_vertex_level(v, level + 1);
  mesh_.set_face_level(f, level + 1);
  change.n = StellarMesh::face(mesh_.twin(StellarMesh::half_edge(f, 2)));
  mesh_.set_face_level(change.n, level + 1);
  if (change.g >= 0) {
    change.m = StellarMesh::face(mesh_.twin(StellarMesh::half_edge(f, 1)));
    mesh_.set_face_level(change.g, level + 1);
    mesh_.set_face_level(change.m, level + 1);
  }
  return change;
}

bool MultiTriangulation::can_weld(int v) const {
  if (v < base_vertices_) return false;
  const int first = mesh_.outgoing(v);
  for (int h = first; h != StellarMesh::kNone;) {
    if (!is_newest(h)) return false;
    h = mesh_.rotate(h);
    if (h == first) break;
  }
  return true;
}

int MultiTriangulation::next_weld(int v) const {
  CONTRACT(v >= base_vertices_);
  for (;;) {
    int finer = StellarMesh::kNone;
    const int first = mesh_.outgoing(v);
    for (int h = first; h != StellarMesh::kNone && finer == StellarMesh::kNone;) {
      if (!is_newest(h)) finer = mesh_.corners(StellarMesh::face(h))[2];
      h = mesh_.rotate(h);
      if (h == first) break;
    }
    if (finer == StellarMesh::kNone) return v;
    v = finer;  // of a higher level, so this ends
  }
}

/// The faces about v are (x, y, v), two or four of them, and two were first children: those of f and g. A
/// first child (c, a, v) starts at the newest vertex of its parent, which is the only corner of the parent's
/// level; in the base, where there is no newest one, first children are those that kept a base slot.
StellarChange MultiTriangulation::describe_weld(int v) const {
  const int level = mesh_.vertex_level(v) - 1;
  int h = mesh_.outgoing(v);
  const auto is_first = [&](int f) {
    return level == 0 ? f < base_faces_ : mesh_.vertex_level(mesh_.corners(f)[0]) == level;
  };
  if (!is_first(StellarMesh::face(h))) h = mesh_.rotate(h);
  StellarChange change;
  change.is_split = false;
  change.vertex = v;
  change.f = StellarMesh::face(h);
  change.c = mesh_.corners(change.f)[0];
  change.a = mesh_.corners(change.f)[1];
  const int cv = mesh_.twin(StellarMesh::half_edge(change.f, 2));
  change.n = StellarMesh::face(cv);
  change.b = mesh_.corners(change.n)[0];
  const int va = mesh_.twin(StellarMesh::half_edge(change.f, 1));
  if (va == StellarMesh::kNone) return change;
  change.m = StellarMesh::face(va);
  change.d = mesh_.corners(change.m)[1];
  change.g = StellarMesh::face(mesh_.twin(StellarMesh::half_edge(change.m, 1)));
  return change;
}

StellarChange MultiTriangulation::weld(int v) {
  const StellarChange change = describe_weld(v);
  const int level = mesh_.vertex_level(v) - 1;
  mesh_.weld_edge(StellarMesh::half_edge(change.f, 1));
  mesh_.set_face_level(change.f, level);
  if (change.g >= 0) mesh_.set_face_level(change.g, level);
  return change;
}

std::vector<std::string> MultiTriangulation::validate() const {
  std::vector<std::string> broken = mesh_.validate();
  if (!broken.empty()) return broken;
  const auto report = [&](int f, const char* what) {
    if (broken.size() < 20) broken.push_back("face " + std::to_string(f) + " " + what);
  };
  for (int f = 0; f < mesh_.face_slots(); ++f) {
    if (!mesh_.is_face(f)) {
      if (f < base_faces_) report(f, "of the base is gone");
      continue;
    }
    const auto& [a, b, c] = mesh_.corners(f);
    if (level(f) > 0 && vertex_level(c) != level(f)) report(f, "does not have its newest vertex last");
    if (level(f) > 0 && (vertex_level(a) >= level(f) || vertex_level(b) >= level(f)))
      report(f, "has a vertex finer than itself");
    if (level(f) == 0 && (vertex_level(a) > 0 || vertex_level(b) > 0 || vertex_level(c) > 0))
      report(f, "of the base has a vertex that is not");
    for (int i = 0; i < 3; ++i) {
      const int t = mesh_.twin(StellarMesh::half_edge(f, i));
      if (t == StellarMesh::kNone) continue;
      const int gap = level(StellarMesh::face(t)) - level(f);
      if (std::abs(gap) > 1) report(f, "has a neighbour more than one level away");
      if (i == 0 && !((t & 3) == 0 && gap == 0) && !((t & 3) != 0 && gap == -1))
        report(f, "has no block, nor a coarser neighbour that gives it one");
    }
  }
  for (int v = 0; v < mesh_.vertex_slots(); ++v) {
    if (!mesh_.is_vertex(v)) {
      if (v < base_vertices_) broken.push_back("vertex " + std::to_string(v) + " of the base is gone");
    } else if ((v < base_vertices_) != (vertex_level(v) == 0)) {
      broken.push_back("vertex " + std::to_string(v) + " has the level of another kind");
    }
  }
  return broken;
}

}  // namespace phiz
