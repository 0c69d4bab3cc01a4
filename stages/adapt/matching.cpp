#include "stages/adapt/matching.h"

#include <algorithm>
#include <numeric>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

constexpr int kNone = -1;

/// Edmonds' search for augmenting paths over the faces of a mesh, with blossoms kept as a union-find forest.
/// A search touches what it looks at and nothing else. An outer face on the border ends a path too: it stays
/// alone.
class Augmenter {
 public:
  Augmenter(const HalfEdgeMesh& mesh, std::vector<int>& mates)
      : mesh_(mesh),
        mates_(mates),
        label_(mates.size(), kUnseen),
        before_(mates.size(), kNone),
        root_(mates.size()),
        stamp_(mates.size(), 0) {
    std::iota(root_.begin(), root_.end(), 0);
  }

  bool augment_from(int start) {
    queue_ = {start};
    touch(start, kOuter);
    bool is_found = false;
    for (std::size_t i = 0; i < queue_.size() && !is_found; ++i) is_found = visit(queue_[i]);
    for (const int f : touched_) {
      label_[f] = kUnseen;
      before_[f] = kNone;
      root_[f] = f;
    }
    touched_.clear();
    return is_found;
  }

 private:
  enum Label : signed char { kUnseen, kOuter, kInner };

  void touch(int f, Label label) {
    label_[f] = label;
    touched_.push_back(f);
  }

  int find_root(int f) {
    while (root_[f] != f) f = root_[f] = root_[root_[f]];
    return f;
  }

  /// Turns the path that ends at `last`, an inner face: pairs it with the one before, and so on to the start.
  void turn_path(int last) {
    while (last != kNone) {
      const int before = before_[last], following = mates_[before];
      mates_[last] = before;
      mates_[before] = last;
      last = following;
    }
  }

  bool visit(int f) {
    for (int i = 0; i < 3; ++i) {
      if (mesh_.twin(3 * f + i) != HalfEdgeMesh::kNone) continue;
      const int mate = mates_[f];  // f may stay alone
      mates_[f] = kNone;
      turn_path(mate);
      return true;
    }
    for (int i = 0; i < 3; ++i) {
      const int g = mesh_.twin(3 * f + i) / 3;
      if (find_root(f) == find_root(g) || label_[g] == kInner) continue;
      if (label_[g] == kOuter) {
        const int base = find_common(f, g);
        shrink(f, g, base);
        shrink(g, f, base);
        continue;
      }
      touch(g, kInner);
      before_[g] = f;
      if (mates_[g] == kNone) {
        turn_path(g);
        return true;
      }
      touch(mates_[g], kOuter);
      queue_.push_back(mates_[g]);
    }
    return false;
  }

  /// The blossom's base: where the ways from both to the start meet.
  int find_common(int f, int g) {
    ++time_;
    for (;;) {
      if (f != kNone) {
        f = find_root(f);
        if (stamp_[f] == time_) return f;
        stamp_[f] = time_;
        const int mate = mates_[f];
        f = mate == kNone ? kNone : before_[mate];
      }
      std::swap(f, g);
    }
  }

  void shrink(int f, int across, int base) {
    while (find_root(f) != base) {
      before_[f] = across;
      across = mates_[f];
      if (label_[across] == kInner) {
        label_[across] = kOuter;
        queue_.push_back(across);
      }
      if (root_[f] == f) root_[f] = base;
      if (root_[across] == across) root_[across] = base;
      f = before_[across];
    }
  }

  const HalfEdgeMesh& mesh_;
  std::vector<int>& mates_;
  std::vector<Label> label_;
  std::vector<int> before_, root_, queue_, touched_;
  std::vector<long long> stamp_;
  long long time_ = 0;
};

double length_of(const HalfEdgeMesh& mesh, std::span<const Eigen::Vector3d> positions, int h) {
  return (positions[mesh.to(h)] - positions[mesh.from(h)]).norm();
}

int find_shared(const HalfEdgeMesh& mesh, std::span<const Eigen::Vector3d> positions, int f, int g) {
  int best = kNone;
  for (int h = 3 * f; h < 3 * f + 3; ++h) {
    const int t = mesh.twin(h);
    if (g == kNone ? t != kNone : (t == kNone || mesh.triangle(t) != g)) continue;
    if (best == kNone || length_of(mesh, positions, h) > length_of(mesh, positions, best)) best = h;
  }
  return best;
}

/// About a vertex whose faces are all paired with one another the other pairing is possible too. Takes it
/// where its edges are longer.
bool turn_about(const HalfEdgeMesh& mesh, std::span<const Eigen::Vector3d> positions, int v,
                std::vector<int>& across) {
  if (mesh.outgoing(v) == HalfEdgeMesh::kNone || mesh.is_border_vertex(v)) return false;
  double paired = 0, other = 0;
  std::vector<int> spokes;
  for (int h = mesh.outgoing(v); spokes.empty() || h != spokes[0]; h = mesh.rotate(h)) spokes.push_back(h);
  if (spokes.size() % 2 != 0 || spokes.size() < 4) return false;
  const auto is_paired = [&](int h) { return across[mesh.triangle(h)] == h; };
  const std::size_t first = is_paired(spokes[0]) ? 0 : 1;
  for (std::size_t i = 0; i < spokes.size(); ++i) {
    const bool should = i % 2 == first;
    if (is_paired(spokes[i]) != should) return false;
    (should ? paired : other) += length_of(mesh, positions, spokes[i]);
  }
  if (other <= paired * (1 + 1e-9)) return false;
  for (std::size_t i = 1 - first; i < spokes.size(); i += 2) {
    const int h = spokes[i];
    across[mesh.triangle(h)] = h;
    across[mesh.triangle(mesh.twin(h))] = mesh.twin(h);
  }
  return true;
}

}  // namespace

BlockMatching match_longest_first(const HalfEdgeMesh& mesh, std::span<const Eigen::Vector3d> positions) {
  std::vector<std::pair<double, int>> edges;
  for (int h = 0; h < mesh.half_edge_count(); ++h)
    if (mesh.twin(h) < h) edges.emplace_back(-length_of(mesh, positions, h), h);
  std::sort(edges.begin(), edges.end());
  BlockMatching matching;
  matching.half_edge.assign(mesh.triangle_count(), kNone);
  for (const auto& [length, h] : edges) {
    const int t = mesh.twin(h), f = mesh.triangle(h);
    if (matching.half_edge[f] != kNone) continue;
    if (t == kNone) {
      matching.half_edge[f] = h;
    } else if (mesh.triangle(t) != f && matching.half_edge[mesh.triangle(t)] == kNone) {
      matching.half_edge[f] = h;
      matching.half_edge[mesh.triangle(t)] = t;
    }
  }
  return matching;
}

void complete_matching(const HalfEdgeMesh& mesh, std::span<const Eigen::Vector3d> positions,
                       BlockMatching& matching) {
  const int count = mesh.triangle_count();
  std::vector<int> mates(count, kNone);
  std::vector<int> alone;
  for (int f = 0; f < count; ++f) {
    const int h = matching.half_edge[f];
    if (h == kNone)
      alone.push_back(f);
    else if (mesh.twin(h) != kNone)
      mates[f] = mesh.triangle(mesh.twin(h));
  }
  Augmenter augmenter(mesh, mates);
  for (const int f : alone) {
    if (mates[f] == kNone && !augmenter.augment_from(f))
      throw NumericalFailure("face " + std::to_string(f) + " of the base can be paired with none");
  }
  for (int f = 0; f < count; ++f) {
    const int h = matching.half_edge[f];
    const int mate_now = h == kNone || mesh.twin(h) == kNone ? kNone : mesh.triangle(mesh.twin(h));
    if (h == kNone || mate_now != mates[f]) matching.half_edge[f] = kNone;
  }
  for (int f = 0; f < count; ++f) {
    if (matching.half_edge[f] != kNone) continue;
    const int h = matching.half_edge[f] = find_shared(mesh, positions, f, mates[f]);
    if (mates[f] != kNone) matching.half_edge[mates[f]] = mesh.twin(h);
  }
  constexpr int kRounds = 8;
  bool is_changed = true;
  for (int round = 0; round < kRounds && is_changed; ++round) {
    is_changed = false;
    for (int v = 0; v < mesh.vertex_count(); ++v)
      is_changed |= turn_about(mesh, positions, v, matching.half_edge);
  }
}

}  // namespace phiz
