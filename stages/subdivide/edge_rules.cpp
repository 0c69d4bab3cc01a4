#include "stages/subdivide/edge_rules.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace phiz {
namespace {

/// sin and cos of pi numerator / denominator by their series: unlike the library's, the same bits on every
/// machine. Error below 1e-13.
double sine(int numerator, int denominator) {
  const double x = std::numbers::pi * (numerator % (2 * denominator)) / denominator - std::numbers::pi;
  double term = x, sum = 0;
  for (int k = 1; k < 40; k += 2) {
    sum += term;
    term *= -x * x / ((k + 1) * (k + 2));
  }
  return -sum;  // sin(x + pi)
}

double cosine(int numerator, int denominator) {
  return sine(2 * numerator + denominator, 2 * denominator);
}

/// Multiples of 2^-48 add up without rounding, so that rows can sum to exactly 1.
double rounded(double weight) {
  return std::nearbyint(weight * 0x1p48) * 0x1p-48;
}

void add(std::vector<Weighted>& row, int vertex_idx, double weight) {
  if (weight == 0) return;
  const auto known = std::find_if(row.begin(), row.end(),
                                  [&](const Weighted& entry) { return entry.vertex_idx == vertex_idx; });
  if (known == row.end())
    row.push_back({vertex_idx, weight});
  else
    known->weight += weight;
}

bool is_regular(const HalfEdgeMesh& mesh, int v) {
  return mesh.valence(v) == (mesh.is_border_vertex(v) ? 4 : 6);
}

/// The vertex of h's triangle that is not on h.
int apex(const HalfEdgeMesh& mesh, int h) {
  return mesh.from(mesh.prev(h));
}

void add_wing(const HalfEdgeMesh& mesh, int side, std::vector<Weighted>& row) {
  constexpr double kWing = -1.0 / 16;
  if (!mesh.is_border_edge(side)) return add(row, apex(mesh, mesh.twin(side)), kWing);
  add(row, mesh.from(side), kWing);
  add(row, mesh.to(side), kWing);
  add(row, apex(mesh, side), -kWing);
}

void add_butterfly(const HalfEdgeMesh& mesh, int h, std::vector<Weighted>& row) {
  add(row, mesh.from(h), 0.5);
  add(row, mesh.to(h), 0.5);
  for (const int half : {h, mesh.twin(h)}) add(row, apex(mesh, half), 1.0 / 8);
  for (const int half : {h, mesh.twin(h)}) {
    add_wing(mesh, mesh.next(half), row);
    add_wing(mesh, mesh.prev(half), row);
  }
}

void add_border_rule(const HalfEdgeMesh& mesh, int h, std::vector<Weighted>& row) {
  add(row, mesh.from(h), 9.0 / 16);
  add(row, mesh.to(h), 9.0 / 16);
  add(row, mesh.ring(mesh.from(h)).back(), -1.0 / 16);      // the border neighbour before
  add(row, mesh.to(mesh.outgoing(mesh.to(h))), -1.0 / 16);  // and behind
}

/// Weight of ring vertex j, counted from the edge to be split, at an inner vertex of the given valence.
double inner_weight(int j, int valence) {
  if (valence == 3) return j == 0 ? 5.0 / 12 : -1.0 / 12;
  if (valence == 4) return j == 0 ? 3.0 / 8 : j == 2 ? -1.0 / 8 : 0.0;
  return (0.25 + cosine(2 * j, valence) + 0.5 * cosine(4 * j, valence)) / valence;
}

/// Weight of ring vertex j at a border vertex of k triangles, where edge i (0 < i < k) is to be split. The
/// ring's values are seen as a sine series over the half-disk once their linear part along the border is
/// taken off: the first two modes shrink by 1/2 and 1/4.
double border_weight(int i, int j, int k) {
  if (j == 0 || j == k) {
    const double along =
        0.25 * cosine(i, k) - sine(2, k) * sine(2 * i, k) / (4 * k * (cosine(1, k) - cosine(2, k)));
    return j == 0 ? along : -along;
  }
  return (sine(i, k) * sine(j, k) + 0.5 * sine(2 * i, k) * sine(2 * j, k)) / k;
}

void add_extraordinary(const HalfEdgeMesh& mesh, int v, int towards, double share,
                       std::vector<Weighted>& row) {
  const std::vector<int> ring = mesh.ring(v);
  const int count = static_cast<int>(ring.size());
  const int split = static_cast<int>(std::find(ring.begin(), ring.end(), towards) - ring.begin());
  const bool on_border = mesh.is_border_vertex(v);
  double of_ring = 0;
  if (!on_border && count == 2) {  // two triangles back to back: nothing to be smooth with
    add(row, towards, 0.5 * share);
    of_ring = 0.5;
  } else {
    for (int n = 0; n < count; ++n) {
      const int j = (split + n) % count;  // outwards from the edge, so that mirrored meshes get mirrored rows
      const double weight = rounded(on_border ? border_weight(split, j, count - 1) : inner_weight(n, count));
      of_ring += weight;
      add(row, ring[j], weight * share);
    }
  }
  add(row, v, (1 - of_ring) * share);
}

}  // namespace

void compute_edge_rule(const HalfEdgeMesh& mesh, int h, std::vector<Weighted>& row) {
  row.clear();
  if (mesh.is_border_edge(h)) return add_border_rule(mesh, h, row);
  const int a = mesh.from(h), b = mesh.to(h);
  const bool regular_a = is_regular(mesh, a), regular_b = is_regular(mesh, b);
  const double share = regular_a || regular_b ? 1.0 : 0.5;
  if (regular_a && regular_b) add_butterfly(mesh, h, row);
  if (!regular_a) add_extraordinary(mesh, a, b, share, row);
  if (!regular_b) add_extraordinary(mesh, b, a, share, row);
  std::erase_if(row, [](const Weighted& entry) { return entry.weight == 0; });
}

}  // namespace phiz
