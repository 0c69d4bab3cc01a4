#include <algorithm>
#include <string>

#include "stages/adapt/stellar_mesh.h"

namespace phiz {
namespace {

constexpr std::size_t kMostBroken = 20;

void report(std::vector<std::string>& broken, const std::string& what) {
  if (broken.size() < kMostBroken) broken.push_back(what);
}

std::string name_of(const char* kind, int index) {
  return std::string(kind) + " " + std::to_string(index);
}

}  // namespace

int StellarMesh::valence(int v) const {
  const int first = outgoing(v);
  if (first == kNone) return 0;
  int faces = 0, h = first;
  do {
    ++faces;
    h = rotate(h);
  } while (h != kNone && h != first);
  return h == kNone ? faces + 1 : faces;
}

std::vector<int> StellarMesh::star(int v) const {
  std::vector<int> faces;
  const int first = outgoing(v);
  for (int h = first; h != kNone;) {
    faces.push_back(face(h));
    h = rotate(h);
    if (h == first) break;
  }
  return faces;
}

std::vector<int> StellarMesh::link(int v) const {
  std::vector<int> ring;
  const int first = outgoing(v);
  for (int h = first; h != kNone;) {
    ring.push_back(to(h));
    const int following = rotate(h);
    if (following == kNone) ring.push_back(from(prev(h)));
    h = following;
    if (h == first) break;
  }
  return ring;
}

int StellarMesh::find_half_edge(int a, int b) const {
  const int first = outgoing(a);
  for (int h = first; h != kNone;) {
    if (to(h) == b) return h;
    h = rotate(h);
    if (h == first) break;
  }
  return kNone;
}

std::vector<std::vector<int>> StellarMesh::border_loops() const {
  std::vector<std::vector<int>> loops;
  std::vector<bool> is_seen(vertices_.size(), false);
  for (int v = 0; v < vertex_slots(); ++v) {
    if (!is_vertex(v) || is_seen[v] || !is_border_vertex(v)) continue;
    std::vector<int>& loop = loops.emplace_back();
    for (int w = v; !is_seen[w]; w = to(outgoing(w))) {
      is_seen[w] = true;
      loop.push_back(w);
    }
  }
  return loops;
}

std::size_t StellarMesh::memory_bytes() const {
  return faces_.capacity() * sizeof(Face) + vertices_.capacity() * sizeof(Vertex);
}

void StellarMesh::validate_face(int f, std::vector<std::string>& broken) const {
  const Face& its = faces_[f];
  const std::string name = name_of("face", f);
  for (int i = 0; i < 3; ++i) {
    const int v = its.corner[i], t = its.twin[i];
    if (v < 0 || v >= vertex_slots() || !is_vertex(v)) {
      report(broken, name + " has a corner that is no vertex");
      continue;
    }
    if (v == its.corner[(i + 1) % 3]) report(broken, name + " names a vertex twice");
    if (t == kNone) continue;
    if (t < 0 || (t & 3) == 3 || face(t) >= face_slots() || !is_face(face(t))) {
      report(broken, name + " has a neighbour that is no face");
    } else if (twin(t) != half_edge(f, i)) {
      report(broken, name + " and its neighbour " + std::to_string(face(t)) + " disagree");
    } else if (from(t) != its.corner[(i + 1) % 3] || to(t) != v) {
      report(broken, name + " and its neighbour " + std::to_string(face(t)) + " do not share an edge");
    }
  }
}

void StellarMesh::validate_vertex(int v, int corners_there, std::vector<std::string>& broken) const {
  const std::string name = name_of("vertex", v);
  const int first = outgoing(v);
  if (first == kNone) {
    if (corners_there > 0) report(broken, name + " has faces and no outgoing half-edge");
    return;
  }
  if (first < 0 || (first & 3) == 3 || face(first) >= face_slots() || !is_face(face(first)) ||
      from(first) != v) {
    report(broken, name + " has an outgoing half-edge that does not start there");
    return;
  }
  int fan = 0, h = first;
  do {
    ++fan;
    h = rotate(h);
  } while (h != kNone && h != first && fan <= corners_there);
  if (fan != corners_there) report(broken, name + " is not a single fan, or turned from the wrong end");
  if (h == kNone && twin(first) != kNone) report(broken, name + " is not turned from the border");
}

void StellarMesh::validate_free(std::vector<std::string>& broken) const {
  int free_faces = 0, free_vertices = 0;
  for (int f = free_face_; f != kNone && free_faces <= face_slots(); f = faces_[f].corner[0]) {
    if (f < 0 || f >= face_slots() || is_face(f)) return report(broken, "the list of free faces is broken");
    ++free_faces;
  }
  for (int v = free_vertex_; v != kNone && free_vertices <= vertex_slots(); v = vertices_[v].outgoing) {
    if (v < 0 || v >= vertex_slots() || is_vertex(v))
      return report(broken, "the list of free vertices is broken");
    ++free_vertices;
  }
  if (free_faces + face_count_ != face_slots()) report(broken, "the count of faces is wrong");
  if (free_vertices + vertex_count_ != vertex_slots()) report(broken, "the count of vertices is wrong");
}

std::vector<std::string> StellarMesh::validate() const {
  std::vector<std::string> broken;
  validate_free(broken);
  std::vector<int> corners_at(vertices_.size(), 0);
  for (int f = 0; f < face_slots(); ++f) {
    if (is_face(f)) validate_face(f, broken);
  }
  if (!broken.empty()) return broken;  // what follows walks along the links
  for (int f = 0; f < face_slots(); ++f) {
    if (!is_face(f)) continue;
    for (const int v : corners(f)) ++corners_at[v];
  }
  for (int v = 0; v < vertex_slots(); ++v) {
    if (is_vertex(v)) validate_vertex(v, corners_at[v], broken);
  }
  return broken;
}

}  // namespace phiz
