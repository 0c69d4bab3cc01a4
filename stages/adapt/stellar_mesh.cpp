#include "stages/adapt/stellar_mesh.h"

#include <algorithm>

#include "stages/geometry/error.h"
#include "stages/geometry/half_edge.h"

namespace phiz {

StellarMesh::StellarMesh(std::span<const Eigen::Vector3i> triangles, int vertex_count) {
  const HalfEdgeMesh mesh(triangles, vertex_count);
  faces_.resize(triangles.size());
  vertices_.resize(vertex_count);
  const auto renumbered = [](int h) { return h == kNone ? kNone : half_edge(h / 3, h % 3); };
  for (int h = 0; h < mesh.half_edge_count(); ++h) {
    faces_[h / 3].corner[h % 3] = mesh.from(h);
    faces_[h / 3].twin[h % 3] = renumbered(mesh.twin(h));
  }
  for (int v = 0; v < vertex_count; ++v) vertices_[v].outgoing = renumbered(mesh.outgoing(v));
  vertex_count_ = vertex_count;
  face_count_ = mesh.triangle_count();
}

int StellarMesh::take_vertex() {
  ++vertex_count_;
  if (free_vertex_ == kNone) {
    vertices_.emplace_back();
    return vertex_slots() - 1;
  }
  const int v = free_vertex_;
  free_vertex_ = vertices_[v].outgoing;
  vertices_[v].level = 0;
  return v;
}

int StellarMesh::take_face(int level) {
  ++face_count_;
  if (free_face_ == kNone) {
    faces_.emplace_back().level = level;
    return face_slots() - 1;
  }
  const int f = free_face_;
  free_face_ = faces_[f].corner[0];
  faces_[f].level = level;
  return f;
}

void StellarMesh::release_vertex(int v) {
  --vertex_count_;
  vertices_[v] = {free_vertex_, -1};
  free_vertex_ = v;
}

void StellarMesh::release_face(int f) {
  --face_count_;
  faces_[f].corner[0] = free_face_;
  faces_[f].level = -1;
  free_face_ = f;
}

void StellarMesh::set_face(int f, const std::array<int, 3>& corner, const std::array<int, 3>& twin) {
  faces_[f].corner = corner;
  faces_[f].twin = twin;
}

void StellarMesh::move_outgoing(int v, Move first, Move second) {
  int& h = vertices_[v].outgoing;
  if (h == first.before)
    h = first.after;
  else if (h == second.before)
    h = second.after;
}

int StellarMesh::split_edge(int h) {
  const int t = twin(h), f = face(h), g = t == kNone ? kNone : face(t);
  const int a = from(h), b = to(h), c = from(prev(h));
  const int bc = next(h), ca = prev(h);
  const int v = take_vertex(), n = take_face(face_level(f));
  const int m = g == kNone ? kNone : take_face(face_level(g));
  const int ad = t == kNone ? kNone : next(t), db = t == kNone ? kNone : prev(t);
  const auto moved = [&](int outer) {  // an outer twin may be a half-edge of f or g itself
    if (outer == bc) return half_edge(n, 0);
    if (outer == ca) return half_edge(f, 0);
    if (t != kNone && outer == ad) return half_edge(m, 0);
    if (t != kNone && outer == db) return half_edge(g, 0);
    return outer;
  };
  const int beyond_bc = moved(twin(bc)), beyond_ca = moved(twin(ca));
  const int beyond_ad = t == kNone ? kNone : moved(twin(ad)),
            beyond_db = t == kNone ? kNone : moved(twin(db));
  const int d = t == kNone ? kNone : from(db);

  set_face(f, {c, a, v}, {beyond_ca, t == kNone ? kNone : half_edge(m, 2), half_edge(n, 1)});
  set_face(n, {b, c, v}, {beyond_bc, half_edge(f, 2), t == kNone ? kNone : half_edge(g, 1)});
  join(beyond_ca, half_edge(f, 0));
  join(beyond_bc, half_edge(n, 0));
  vertices_[v].outgoing = half_edge(n, 2);
  move_outgoing(a, {h, half_edge(f, 1)}, {ad, half_edge(m, 0)});
  move_outgoing(b, {bc, half_edge(n, 0)}, {t, half_edge(g, 1)});
  move_outgoing(c, {ca, half_edge(f, 0)}, {ca, half_edge(f, 0)});
  if (t == kNone) return v;
  set_face(g, {d, b, v}, {beyond_db, half_edge(n, 2), half_edge(m, 1)});
  set_face(m, {a, d, v}, {beyond_ad, half_edge(g, 2), half_edge(f, 1)});
  join(beyond_db, half_edge(g, 0));
  join(beyond_ad, half_edge(m, 0));
  move_outgoing(d, {db, half_edge(g, 0)}, {db, half_edge(g, 0)});
  return v;
}

void StellarMesh::weld_edge(int h) {
  const int t = twin(h), f = face(h), v = to(h);
  const int ca = prev(h), cv = twin(next(h)), n = face(cv), bc = prev(cv);
  const int a = from(h), b = from(bc), c = from(ca);
  const bool inside = t != kNone;
  const int ad = inside ? next(t) : kNone, vd = inside ? twin(prev(t)) : kNone;
  const int bv = inside ? prev(vd) : kNone, db = inside ? next(vd) : kNone;
  const int m = inside ? face(t) : kNone, g = inside ? face(vd) : kNone, d = inside ? from(db) : kNone;
  const auto moved = [&](int outer) {
    if (outer == ca) return half_edge(f, 2);
    if (outer == bc) return half_edge(f, 1);
    if (inside && outer == ad) return half_edge(g, 1);
    if (inside && outer == db) return half_edge(g, 2);
    return outer;
  };
  const int beyond_bc = moved(twin(bc)), beyond_ca = moved(twin(ca));
  const int beyond_ad = inside ? moved(twin(ad)) : kNone, beyond_db = inside ? moved(twin(db)) : kNone;

  move_outgoing(a, {h, half_edge(f, 0)}, {ad, half_edge(g, 1)});
  move_outgoing(b, {bc, half_edge(f, 1)}, {bv, half_edge(g, 0)});
  move_outgoing(c, {ca, half_edge(f, 2)}, {cv, half_edge(f, 2)});
  set_face(f, {a, b, c}, {inside ? half_edge(g, 0) : kNone, beyond_bc, beyond_ca});
  join(beyond_bc, half_edge(f, 1));
  join(beyond_ca, half_edge(f, 2));
  if (inside) {
    move_outgoing(d, {db, half_edge(g, 2)}, {prev(t), half_edge(g, 2)});
    set_face(g, {b, a, d}, {half_edge(f, 0), beyond_ad, beyond_db});
    join(beyond_ad, half_edge(g, 1));
    join(beyond_db, half_edge(g, 2));
    release_face(m);
  }
  release_face(n);
  release_vertex(v);
}

bool StellarMesh::can_weld_edge(int h) const {
  const int v = to(h);
  if (is_border_vertex(v)) {
    if (valence(v) != 3 || twin(h) != kNone) return false;
    return find_half_edge(from(h), to(next(twin(next(h))))) == kNone &&
           find_half_edge(from(prev(twin(next(h)))), from(h)) == kNone;
  }
  if (twin(h) == kNone || valence(v) != 4) return false;
  const int a = from(h), b = from(prev(twin(next(h))));
  return a != b && find_half_edge(a, b) == kNone && find_half_edge(b, a) == kNone;
}

int StellarMesh::split_face(int f) {
  const auto [a, b, c] = corners(f);
  const int bc = half_edge(f, 1), ca = half_edge(f, 2);
  const int v = take_vertex(), n = take_face(face_level(f)), m = take_face(face_level(f));
  const auto moved = [&](int outer) {
    return outer == bc ? half_edge(n, 0) : outer == ca ? half_edge(m, 0) : outer;
  };
  const int beyond_ab = moved(twin(half_edge(f, 0))), beyond_bc = moved(twin(bc)),
            beyond_ca = moved(twin(ca));
  set_face(f, {a, b, v}, {beyond_ab, half_edge(n, 2), half_edge(m, 1)});
  set_face(n, {b, c, v}, {beyond_bc, half_edge(m, 2), half_edge(f, 1)});
  set_face(m, {c, a, v}, {beyond_ca, half_edge(f, 2), half_edge(n, 1)});
  join(beyond_bc, half_edge(n, 0));
  join(beyond_ca, half_edge(m, 0));
  move_outgoing(b, {bc, half_edge(n, 0)}, {bc, half_edge(n, 0)});
  move_outgoing(c, {ca, half_edge(m, 0)}, {ca, half_edge(m, 0)});
  vertices_[v].outgoing = half_edge(f, 2);
  return v;
}

bool StellarMesh::can_weld_face(int v) const {
  return outgoing(v) != kNone && !is_border_vertex(v) && valence(v) == 3;
}

void StellarMesh::weld_face(int h) {
  const int f = face(h), v = from(prev(h)), a = from(h), b = to(h);
  const int vb = twin(next(h)), bc = next(vb), n = face(vb);
  const int av = twin(prev(h)), ca = prev(av), m = face(av);
  const int c = from(ca);
  const auto moved = [&](int outer) {
    if (outer == h) return half_edge(f, 0);
    return outer == bc ? half_edge(f, 1) : outer == ca ? half_edge(f, 2) : outer;
  };
  const int beyond_ab = moved(twin(h)), beyond_bc = moved(twin(bc)), beyond_ca = moved(twin(ca));
  move_outgoing(a, {h, half_edge(f, 0)}, {av, half_edge(f, 0)});
  move_outgoing(b, {bc, half_edge(f, 1)}, {next(h), half_edge(f, 1)});
  move_outgoing(c, {ca, half_edge(f, 2)}, {prev(vb), half_edge(f, 2)});
  set_face(f, {a, b, c}, {beyond_ab, beyond_bc, beyond_ca});
  join(beyond_ab, half_edge(f, 0));
  join(beyond_bc, half_edge(f, 1));
  join(beyond_ca, half_edge(f, 2));
  release_face(m);
  release_face(n);
  release_vertex(v);
}

}  // namespace phiz
