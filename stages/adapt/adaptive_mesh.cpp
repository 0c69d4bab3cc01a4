#include "stages/adapt/adaptive_mesh.h"

#include <algorithm>
#include <cmath>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

constexpr int kAskEvery = 64;
constexpr int kMostRounds = 8;  ///< of refinement and simplification where tests look at neighbours

}  // namespace

AdaptiveMesh::AdaptiveMesh(AdaptiveSurface& surface)
    : surface_(surface),
      triangulation_(surface.base().triangles, static_cast<int>(surface.base().uv.size())),
      uv_(surface.base().uv),
      samples_(uv_.size()),
      width_(surface.base().attribute_count),
      attributes_(surface.base().attributes) {
  if (attributes_.size() != uv_.size() * static_cast<std::size_t>(width_))
    throw InvalidInput("the base has not " + std::to_string(width_) + " attributes a vertex");
  resample();
}

void AdaptiveMesh::resample() {
  for (int v = 0; v < mesh().vertex_slots(); ++v) {
    if (mesh().is_vertex(v)) samples_[v] = surface_.sample(*this, {v, -1, -1, -1, uv_[v]});
  }
  surface_.on_resample(*this);
}

void AdaptiveMesh::take_sample(const StellarChange& change) {
  const auto v = static_cast<std::size_t>(change.vertex);
  if (v >= uv_.size()) {
    uv_.resize(v + 1);
    samples_.resize(v + 1);
    attributes_.resize((v + 1) * width_);
  }
  uv_[v] = 0.5 * (uv_[change.a] + uv_[change.b]);
  samples_[v] = surface_.sample(*this, {change.vertex, change.a, change.b, change.f, uv_[v]});
  for (int k = 0; k < width_; ++k)
    attributes_[v * width_ + k] = 0.5f * (attribute(change.a, k) + attribute(change.b, k));
}

void AdaptiveMesh::apply(const StellarChange& change) {
  if (change.is_split) take_sample(change);
  if (is_recording_) changes_.push_back(change);
  surface_.on_change(*this, change);
}

int AdaptiveMesh::refine_chain(int face) {
  int splits = 0;
  triangulation_.refine(face, [&](const StellarChange& change) {
    apply(change);
    ++splits;
    for (const int f : {change.f, change.n, change.g, change.m})
      if (f >= 0) pending_.push_back(f);
  });
  return splits;
}

int AdaptiveMesh::simplify_chain(int vertex) {
  int welds = 0;
  triangulation_.simplify(vertex, [&](const StellarChange& change) {
    apply(change);
    ++welds;
  });
  return welds;
}

void AdaptiveMesh::refine_face(int face) {
  CONTRACT(mesh().is_face(face));
  refine_chain(face);
  pending_.clear();
}

void AdaptiveMesh::simplify_vertex(int vertex) {
  CONTRACT(mesh().is_vertex(vertex) && vertex >= triangulation_.base_vertex_count());
  simplify_chain(vertex);
}

void AdaptiveMesh::simplify_all() {
  for (int v = triangulation_.base_vertex_count(); v < mesh().vertex_slots(); ++v) {
    if (mesh().is_vertex(v)) simplify_chain(v);
  }
}

bool AdaptiveMesh::may_go_on(const AdaptBudget& budget, int& requests) const {
  if (mesh().vertex_count() >= budget.vertices) return false;
  return ++requests % kAskEvery != 0 || !budget.keep_going || budget.keep_going();
}

/// Faces whose test may have another answer since the last splits: new ones, and where a test looks across
/// its edge, those that see a new one there.
void AdaptiveMesh::add_onlookers(std::size_t first_new) {
  for (std::size_t i = first_new, end = pending_.size(); i < end; ++i) {
    if (!mesh().is_face(pending_[i])) continue;
    const int t = mesh().twin(StellarMesh::half_edge(pending_[i], 0));
    if (t != StellarMesh::kNone && (t & 3) == 0) pending_.push_back(StellarMesh::face(t));
  }
}

AdaptReport AdaptiveMesh::refine(const AdaptBudget& budget) {
  AdaptReport report;
  const int level = std::min(budget.level, MultiTriangulation::kMostLevel);
  const bool is_local = surface_.is_face_local();
  pending_.clear();
  for (int f = 0; f < mesh().face_slots(); ++f)
    if (mesh().is_face(f)) pending_.push_back(f);
  int requests = 0;
  for (std::size_t i = 0; i < pending_.size() && report.is_done; ++i) {
    const int f = pending_[i];
    while (mesh().is_face(f) && triangulation_.level(f) < level && surface_.should_refine(*this, f)) {
      report.is_done = may_go_on(budget, requests);
      if (!report.is_done) break;
      const std::size_t first_new = pending_.size();
      report.splits += refine_chain(f);
      if (!is_local) add_onlookers(first_new);
    }
  }
  pending_.clear();
  return report;
}

AdaptReport AdaptiveMesh::simplify(const AdaptBudget& budget) {
  AdaptReport report;
  std::vector<int> candidates;
  for (int v = triangulation_.base_vertex_count(); v < mesh().vertex_slots(); ++v)
    if (mesh().is_vertex(v) && triangulation_.can_weld(v)) candidates.push_back(v);
  int requests = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const int v = candidates[i];
    if (!mesh().is_vertex(v) || !triangulation_.can_weld(v)) continue;
    const StellarChange weld = triangulation_.describe_weld(v);
    if (!surface_.may_simplify(*this, weld)) continue;
    if (++requests % kAskEvery == 0 && budget.keep_going && !budget.keep_going()) {
      report.is_done = false;
      break;
    }
    report.welds += simplify_chain(v);
    for (const int corner : {weld.a, weld.b, weld.c, weld.d})
      if (corner >= triangulation_.base_vertex_count()) candidates.push_back(corner);
  }
  return report;
}

AdaptReport AdaptiveMesh::adapt(const AdaptBudget& budget) {
  AdaptReport total;
  for (int round = 0; round < kMostRounds; ++round) {
    const AdaptReport finer = refine(budget), coarser = simplify(budget);
    total.splits += finer.splits;
    total.welds += coarser.welds;
    total.is_done = finer.is_done && coarser.is_done;
    const bool is_settled = finer.splits == 0 && coarser.welds == 0;
    if (is_settled || !coarser.is_done || (finer.is_done && surface_.is_face_local())) break;
    if (!finer.is_done && coarser.welds == 0) break;
  }
  return total;
}

TriangleMesh AdaptiveMesh::to_triangle_mesh() const {
  TriangleMesh made;
  std::vector<int> index(mesh().vertex_slots(), -1);
  for (int v = 0; v < mesh().vertex_slots(); ++v) {
    if (!mesh().is_vertex(v)) continue;
    index[v] = static_cast<int>(made.positions.size());
    made.positions.push_back(position(v));
    made.normals.push_back(normal(v));
    made.uv.push_back(uv(v).cast<float>());
  }
  for (int f = 0; f < mesh().face_slots(); ++f) {
    if (!mesh().is_face(f)) continue;
    const auto& [a, b, c] = mesh().corners(f);
    made.triangles.emplace_back(index[a], index[b], index[c]);
  }
  return made;
}

std::vector<std::string> AdaptiveMesh::validate() const {
  std::vector<std::string> broken = triangulation_.validate();
  if (!broken.empty()) return broken;
  const auto report = [&](const char* kind, int index, const char* what) {
    if (broken.size() < 20) broken.push_back(kind + std::to_string(index) + what);
  };
  for (int v = 0; v < mesh().vertex_slots(); ++v) {
    if (mesh().is_vertex(v) && !(position(v).allFinite() && normal(v).allFinite() && uv(v).allFinite()))
      report("vertex ", v, " has a number that is not finite");
  }
  for (int f = 0; f < mesh().face_slots(); ++f) {
    if (!mesh().is_face(f)) continue;
    const auto& [a, b, c] = mesh().corners(f);
    const Eigen::Vector2d ab = uv(b) - uv(a), ac = uv(c) - uv(a);
    if (!(ab.x() * ac.y() - ab.y() * ac.x() > 0)) report("face ", f, " is turned over in (u,v)");
  }
  return broken;
}

std::size_t AdaptiveMesh::memory_bytes() const {
  return mesh().memory_bytes() + uv_.capacity() * sizeof(Eigen::Vector2d) +
         samples_.capacity() * sizeof(VertexSample) + attributes_.capacity() * sizeof(float);
}

}  // namespace phiz
