#include "stages/retarget/bounded_solve.h"

#include <Eigen/Cholesky>
#include <vector>

namespace phiz {

Eigen::VectorXd solve_bounded(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& low,
                              const Eigen::VectorXd& high) {
  const Eigen::Index n = b.size();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n).cwiseMax(low).cwiseMin(high);
  std::vector<int> held(static_cast<std::size_t>(n), 0);  // -1 at low, 1 at high
  for (Eigen::Index pass = 0; pass < 3 * n + 10; ++pass) {
    std::vector<Eigen::Index> open;
    for (Eigen::Index i = 0; i < n; ++i) {
      if (held[i] == 0)
        open.push_back(i);
      else
        x[i] = held[i] < 0 ? low[i] : high[i];
    }
    const auto m = static_cast<Eigen::Index>(open.size());
    Eigen::MatrixXd part(m, m);
    Eigen::VectorXd rest(m);
    for (Eigen::Index i = 0; i < m; ++i) {
      rest[i] = b[open[i]];
      for (Eigen::Index j = 0; j < n; ++j) {
        if (held[j] != 0) rest[i] -= a(open[i], j) * x[j];
      }
      for (Eigen::Index j = 0; j < m; ++j) part(i, j) = a(open[i], open[j]);
    }
    const Eigen::VectorXd solved = part.ldlt().solve(rest);
    bool is_changed = false;
    for (Eigen::Index i = 0; i < m; ++i) {
      const Eigen::Index k = open[i];
      x[k] = solved[i];
      if (solved[i] < low[k]) held[k] = -1, is_changed = true;
      if (solved[i] > high[k]) held[k] = 1, is_changed = true;
    }
    if (is_changed) continue;
    // Let go of the one held variable that pulls inwards most.
    const Eigen::VectorXd slope = a * x - b;
    Eigen::Index worst = -1;
    double most = 1e-9;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double inwards = held[i] < 0 ? -slope[i] : held[i] > 0 ? slope[i] : 0;
      if (inwards > most) most = inwards, worst = i;
    }
    if (worst < 0) break;
    held[worst] = 0;
  }
  return x.cwiseMax(low).cwiseMin(high);
}

}  // namespace phiz
