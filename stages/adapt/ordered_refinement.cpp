#include <algorithm>
#include <queue>

#include "stages/adapt/adaptive_mesh.h"

namespace phiz {
namespace {

constexpr int kMostExchanges = 12;
constexpr double kNeedless = 0.8;  ///< welds whose error stays below this share of the worst are taken

}  // namespace

/// Faces by falling error; an entry is stale once its face has changed.
struct AdaptiveMesh::OrderedQueue {
  struct Entry {
    double error;
    int face;
    unsigned stamp;
    bool operator<(const Entry& other) const {
      return error != other.error ? error < other.error : face > other.face;
    }
  };
  std::priority_queue<Entry> entries;
  std::vector<unsigned> stamps;

  void put(const AdaptiveMesh& mesh, AdaptiveSurface& surface, int f) {
    if (f >= static_cast<int>(stamps.size())) stamps.resize(f + 1, 0);
    entries.push({surface.error(mesh, f), f, ++stamps[f]});
  }
  bool is_stale(const AdaptiveMesh& mesh, const Entry& entry) const {
    return !mesh.mesh().is_face(entry.face) || stamps[entry.face] != entry.stamp;
  }
};

void AdaptiveMesh::spend(const AdaptBudget& budget, OrderedQueue& queue, AdaptReport& report) {
  const int level = std::min(budget.level, MultiTriangulation::kMostLevel);
  int requests = 0;
  report.is_done = true;
  while (!queue.entries.empty()) {
    const OrderedQueue::Entry worst = queue.entries.top();
    if (queue.is_stale(*this, worst) || triangulation_.level(worst.face) >= level) {
      queue.entries.pop();
      continue;
    }
    report.error = worst.error;
    if (worst.error <= budget.error) return;
    if (!may_go_on(budget, requests)) {
      report.is_done = false;
      return;
    }
    queue.entries.pop();
    pending_.clear();
    report.splits += refine_chain(worst.face);
    for (const int f : pending_) queue.put(*this, surface_, f);
  }
  report.error = 0;
}

/// Welds what would leave no more error than `limit`.
int AdaptiveMesh::exchange(double limit) {
  int welds = 0;
  std::vector<int> candidates;
  for (int v = triangulation_.base_vertex_count(); v < mesh().vertex_slots(); ++v)
    if (mesh().is_vertex(v)) candidates.push_back(v);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const int v = candidates[i];
    if (!mesh().is_vertex(v) || !triangulation_.can_weld(v)) continue;
    const StellarChange weld = triangulation_.describe_weld(v);
    if (surface_.weld_error(*this, weld) > limit) continue;
    welds += simplify_chain(v);
    for (const int corner : {weld.a, weld.b, weld.c, weld.d})
      if (corner >= triangulation_.base_vertex_count()) candidates.push_back(corner);
  }
  return welds;
}

AdaptReport AdaptiveMesh::refine_in_order(const AdaptBudget& budget) {
  AdaptReport report;
  const auto fill = [&](OrderedQueue& queue) {
    for (int f = 0; f < mesh().face_slots(); ++f)
      if (mesh().is_face(f)) queue.put(*this, surface_, f);
  };
  OrderedQueue queue;
  fill(queue);
  spend(budget, queue, report);
  for (int round = 0; round < kMostExchanges && !report.is_done; ++round) {
    if (budget.keep_going && !budget.keep_going()) break;
    const double before = report.error;
    const int welds = exchange(kNeedless * report.error);
    if (welds == 0) break;
    report.welds += welds;
    OrderedQueue next;
    fill(next);
    spend(budget, next, report);
    if (report.error >= before) break;
  }
  pending_.clear();
  return report;
}

}  // namespace phiz
