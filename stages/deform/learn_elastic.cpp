#include "stages/deform/learn_elastic.h"

#include <Eigen/SVD>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "stages/deform/block_matrix.h"
#include "stages/deform/elastic_step.h"
#include "stages/geometry/error.h"
#include "stages/geometry/half_edge.h"
#include "stages/geometry/normals.h"
#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

using Positions = std::vector<Eigen::Vector3d>;
using Stencils = Eigen::SparseMatrix<double, Eigen::RowMajor>;

constexpr int kLevels = 3;
constexpr double kPocketSoftness = 0.02;  ///< strain of the mouth's pocket costs so much of skin's
constexpr double kAlongSurface =
    0.3;  ///< bending along the surface costs so much of bending of the normal part
constexpr double kHoldScaleMm = 0.3;
constexpr double kRobustShare = 0.35;  ///< of the reach
constexpr double kMeasureBelowMm = 1.9;
constexpr double kNormalWeightMm = 10;  ///< in the search for matches
constexpr double kMeasureWidthMm = 1.2;
constexpr double kLeastPocket = 0.3, kLeastMovable = 0.05;
constexpr double kDamping = 1e-6;
constexpr int kRotationSmoothing = 2;

Stencils compose(const SubdivisionHierarchy& hierarchy, int level) {
  const int controls = hierarchy.vertex_count(0);
  Stencils all(controls, controls);
  all.setIdentity();
  for (int k = 1; k <= level; ++k) {
    const auto& rows = hierarchy.stencils(k);
    const int old_count = hierarchy.vertex_count(k - 1);
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < old_count; ++i) entries.emplace_back(i, i, 1.0);
    for (int row = old_count; row < hierarchy.vertex_count(k); ++row) {
      for (int e = rows.offsets[row - old_count]; e < rows.offsets[row - old_count + 1]; ++e)
        entries.emplace_back(row, rows.vertices[e], rows.weights[e]);
    }
    Stencils step(hierarchy.vertex_count(k), old_count);
    step.setFromTriplets(entries.begin(), entries.end());
    all = (step * all).pruned();
  }
  return all;
}

std::vector<double> vertex_areas(const Positions& positions, const std::vector<Eigen::Vector3i>& triangles) {
  std::vector<double> areas(positions.size(), 0);
  for (const Eigen::Vector3i& t : triangles) {
    const double third =
        (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]).norm() / 6;
    for (const int corner : t) areas[corner] += third;
  }
  return areas;
}

struct Edge {
  int a, b;
  double weight;
};

struct Match {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double offset_mm = 0, weight = 0;
};

Match find_match(const ScanSurface& scan, const Eigen::Vector3d& position, const Eigen::Vector3d& normal,
                 double reach_mm) {
  Match found;
  double facing = 0, confidence = 0;
  if (reach_mm > kMeasureBelowMm) {
    const auto nearest = scan.find_match(position.cast<float>(), normal.cast<float>(),
                                         static_cast<float>(kNormalWeightMm), static_cast<float>(reach_mm));
    if (nearest.surfel_idx < 0) return {};
    const Surfel& surfel = scan.surfels()[nearest.surfel_idx];
    if (surfel.border > 0.8f && nearest.distance > 1.5f) return {};
    facing = surfel.normal.cast<double>().dot(normal);
    found.normal = (surfel.normal.cast<double>() + normal).normalized();
    found.offset_mm = found.normal.dot(surfel.position.cast<double>() - position);
    confidence = 0.1 + surfel.confidence;
  } else {
    const auto measured = scan.measure(position.cast<float>(), normal.cast<float>(),
                                       static_cast<float>(kMeasureWidthMm), static_cast<float>(reach_mm));
    facing = measured.normal.cast<double>().dot(normal);
    if (measured.confidence <= 0 || facing < 0.3) return {};
    found.normal = measured.normal.cast<double>();
    found.offset_mm = measured.offset_mm * facing;
    confidence = measured.confidence;
  }
  if (facing <= 0) return {};
  const double relative = found.offset_mm / (kRobustShare * reach_mm);
  found.weight = confidence * facing * facing / std::pow(1 + relative * relative, 2);
  return found;
}

}  // namespace

struct ElasticSkin::Impl {
  const SubdivisionHierarchy& hierarchy;
  std::vector<Positions> neutral;
  std::vector<Stencils> stencils;
  std::vector<std::vector<double>> areas;
  std::vector<std::vector<char>> is_matched;  ///< per level and vertex
  std::vector<int> unknown;                   ///< control vertex -> row, -1 if it does not move
  std::vector<char> is_pocket;
  std::vector<Edge> edges;
  Stencils laplacian;
  BlockMatrix matrix;
  Eigen::VectorXd right;
  double mean_distance_mm = 0;

  Impl(const SubdivisionHierarchy& h, std::vector<Positions> levels)
      : hierarchy(h), neutral(std::move(levels)) {}

  void add(int a, int b, const Eigen::Matrix3d& block) {
    if (unknown[a] >= 0 && unknown[b] >= 0) matrix.add(unknown[a], unknown[b], block);
  }
  void add(int a, const Eigen::Vector3d& force) {
    if (unknown[a] >= 0) right.segment<3>(3 * unknown[a]) += force;
  }

  void weigh_edges(const std::vector<Eigen::Vector3i>& triangles);
  void set_pattern();
  Positions surface(const Positions& x, int level) const;
  std::vector<Eigen::Matrix3d> rotations(const Positions& x, const Positions& rest) const;
  void add_matches(const ScanSurface& scan, const Positions& x, const ElasticRound& round);
  void add_elasticity(const Positions& x, const Positions& rest, const ElasticRound& round);
};

/// Cotangent weights of the neutral control mesh, kept positive; triangles of the pocket weigh little.
void ElasticSkin::Impl::weigh_edges(const std::vector<Eigen::Vector3i>& triangles) {
  const Positions& p = neutral[0];
  std::map<std::pair<int, int>, double> weights;
  for (const Eigen::Vector3i& t : triangles) {
    const bool is_soft = is_pocket[t[0]] || is_pocket[t[1]] || is_pocket[t[2]];
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
      const Eigen::Vector3d u = p[a] - p[c], v = p[b] - p[c];
      const double cotangent = std::clamp(u.dot(v) / std::max(1e-9, u.cross(v).norm()), 0.05, 5.0);
      weights[std::minmax(a, b)] += 0.5 * cotangent * (is_soft ? kPocketSoftness : 1);
    }
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& [pair, weight] : weights) {
    edges.push_back({pair.first, pair.second, weight});
    entries.emplace_back(pair.first, pair.second, -weight);
    entries.emplace_back(pair.second, pair.first, -weight);
    entries.emplace_back(pair.first, pair.first, weight);
    entries.emplace_back(pair.second, pair.second, weight);
  }
  const auto count = static_cast<Eigen::Index>(p.size());
  laplacian.resize(count, count);
  laplacian.setFromTriplets(entries.begin(), entries.end());
}

void ElasticSkin::Impl::set_pattern() {
  const int count =
      static_cast<int>(std::count_if(unknown.begin(), unknown.end(), [](int u) { return u >= 0; }));
  std::vector<std::vector<int>> columns(count);
  std::vector<int> row;
  const auto take = [&](const Stencils& rows, Eigen::Index r) {
    row.clear();
    for (Stencils::InnerIterator it(rows, r); it; ++it)
      if (unknown[it.col()] >= 0) row.push_back(unknown[it.col()]);
    for (const int a : row)
      for (const int b : row)
        if (b <= a) columns[a].push_back(b);
    for (const int a : row) {  // bounded memory: most pairs come many times
      if (columns[a].size() < 4096) continue;
      std::sort(columns[a].begin(), columns[a].end());
      columns[a].erase(std::unique(columns[a].begin(), columns[a].end()), columns[a].end());
    }
  };
  for (int level = 1; level <= kLevels; ++level)
    for (Eigen::Index r = 0; r < stencils[level].rows(); ++r) take(stencils[level], r);
  for (Eigen::Index r = 0; r < laplacian.rows(); ++r) take(laplacian, r);
  matrix.set_pattern(std::move(columns));
}

Positions ElasticSkin::Impl::surface(const Positions& x, int level) const {
  Eigen::MatrixX3d moved(x.size(), 3);
  for (std::size_t i = 0; i < x.size(); ++i) moved.row(i) = (x[i] - neutral[0][i]).transpose();
  const Eigen::MatrixX3d by = stencils[level] * moved;
  Positions at = neutral[level];
  for (std::size_t i = 0; i < at.size(); ++i) at[i] += by.row(i).transpose();
  return at;
}

/// How the surroundings of each control vertex have turned since `rest`.
std::vector<Eigen::Matrix3d> ElasticSkin::Impl::rotations(const Positions& x, const Positions& rest) const {
  std::vector<Eigen::Matrix3d> turns(x.size(), Eigen::Matrix3d::Zero());
  std::vector<double> sums(x.size(), 0);
  for (const Edge& e : edges) {
    const Eigen::Matrix3d outer = e.weight * (x[e.a] - x[e.b]) * (rest[e.a] - rest[e.b]).transpose();
    turns[e.a] += outer;
    turns[e.b] += outer;
    sums[e.a] += e.weight;
    sums[e.b] += e.weight;
  }
  for (int pass = 0; pass < kRotationSmoothing; ++pass) {
    std::vector<Eigen::Matrix3d> around(x.size(), Eigen::Matrix3d::Zero());
    for (const Edge& e : edges) {
      around[e.a] += e.weight * turns[e.b];
      around[e.b] += e.weight * turns[e.a];
    }
    for (std::size_t i = 0; i < x.size(); ++i)
      turns[i] = 0.5 * turns[i] + 0.5 * around[i] / std::max(1e-12, sums[i]);
  }
  parallel_for(x.size(), 128, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Eigen::JacobiSVD<Eigen::Matrix3d> svd(turns[i], Eigen::ComputeFullU | Eigen::ComputeFullV);
      const bool flips = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0;
      const Eigen::Vector3d signs(1, 1, flips ? -1 : 1);
      turns[i] = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
    }
  });
  return turns;
}

void ElasticSkin::Impl::add_matches(const ScanSurface& scan, const Positions& x, const ElasticRound& round) {
  const Positions at = surface(x, round.level);
  const Positions normals =
      compute_vertex_normals(std::span<const Eigen::Vector3d>(at), hierarchy.triangles(round.level));
  std::vector<Match> matches(at.size());
  parallel_for(at.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (is_matched[round.level][i]) matches[i] = find_match(scan, at[i], normals[i], round.reach_mm);
  });
  double distances = 0, weights = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const Match& m = matches[i];
    if (m.weight <= 0) continue;
    const double weight = m.weight * areas[round.level][i];
    distances += weight * std::abs(m.offset_mm);
    weights += weight;
    const Eigen::Matrix3d outer = weight * m.normal * m.normal.transpose();
    const Eigen::Vector3d force = weight * m.offset_mm * m.normal;
    const auto r = static_cast<Eigen::Index>(i);
    for (Stencils::InnerIterator a(stencils[round.level], r); a; ++a) {
      add(static_cast<int>(a.col()), a.value() * force);
      for (Stencils::InnerIterator b(stencils[round.level], r); b; ++b)
        if (b.col() <= a.col())
          add(static_cast<int>(a.col()), static_cast<int>(b.col()), a.value() * b.value() * outer);
    }
  }
  mean_distance_mm = weights > 0 ? distances / weights : 0;
}

/// Strain (as rigid as possible), bending, hold: linearised about x with the turns of the surroundings.
void ElasticSkin::Impl::add_elasticity(const Positions& x, const Positions& rest, const ElasticRound& round) {
  const std::vector<Eigen::Matrix3d> turns = rotations(x, rest);
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
  Positions bent(x.size(), Eigen::Vector3d::Zero());
  for (const Edge& e : edges) {
    const Eigen::Vector3d now = x[e.a] - x[e.b], then = rest[e.a] - rest[e.b];
    const Eigen::Vector3d change = now - 0.5 * (turns[e.a] + turns[e.b]) * then;
    const double price = round.strain * e.weight;
    add(e.a, e.a, price * one);
    add(e.b, e.b, price * one);
    add(e.a, e.b, -price * one);
    add(e.a, -price * change);
    add(e.b, price * change);
    bent[e.a] += e.weight * (now - turns[e.a] * then);
    bent[e.b] -= e.weight * (now - turns[e.b] * then);
  }
  const Positions normals =
      compute_vertex_normals(std::span<const Eigen::Vector3d>(x), hierarchy.triangles(0));
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double price = round.bending / std::max(1.0, areas[0][i]);
    const Eigen::Matrix3d shape =
        price * (kAlongSurface * one + (1 - kAlongSurface) * normals[i] * normals[i].transpose());
    for (Stencils::InnerIterator a(laplacian, static_cast<Eigen::Index>(i)); a; ++a) {
      add(static_cast<int>(a.col()), -a.value() * (shape * bent[i]));
      for (Stencils::InnerIterator b(laplacian, static_cast<Eigen::Index>(i)); b; ++b)
        if (b.col() <= a.col())
          add(static_cast<int>(a.col()), static_cast<int>(b.col()), a.value() * b.value() * shape);
    }
    const int v = static_cast<int>(i);
    const Eigen::Vector3d moved = x[i] - rest[i];
    const double hold =
        round.hold * areas[0][i] / (1 + moved.squaredNorm() / (kHoldScaleMm * kHoldScaleMm)) + kDamping;
    add(v, v, hold * one);
    add(v, -hold * moved);
  }
}

ElasticSkin::ElasticSkin(const ControlMesh& generic_head, const SubdivisionHierarchy& hierarchy,
                         std::vector<Positions> neutral_levels, const std::vector<bool>& movable)
    : impl_(std::make_unique<Impl>(hierarchy, std::move(neutral_levels))) {
  Impl& skin = *impl_;
  CONTRACT(hierarchy.level_count() >= kLevels && skin.neutral.size() == kLevels + 1u &&
           movable.size() == skin.neutral[0].size());
  skin.is_pocket.assign(movable.size(), 0);
  for (const int v : generic_head.annotations.constrained_vertices) skin.is_pocket[v] = 1;
  const auto mouth = generic_head.annotations.regions.find("inner_mouth");
  if (mouth != generic_head.annotations.regions.end())
    for (const int v : mouth->second) skin.is_pocket[v] = 1;
  int rows = 0;
  for (const bool moves : movable) skin.unknown.push_back(moves ? rows++ : -1);
  if (rows == 0) throw InvalidInput("nothing may move");
  for (int level = 0; level <= kLevels; ++level) {
    skin.stencils.push_back(compose(hierarchy, level));
    skin.areas.push_back(vertex_areas(skin.neutral[level], hierarchy.triangles(level)));
    std::vector<char> matched(skin.neutral[level].size(), 0);
    for (std::size_t i = 0; i < matched.size(); ++i) {
      double pocket = 0, moves = 0;
      for (Stencils::InnerIterator it(skin.stencils[level], static_cast<Eigen::Index>(i)); it; ++it) {
        pocket += it.value() * skin.is_pocket[it.col()];
        moves += it.value() * (skin.unknown[it.col()] >= 0);
      }
      matched[i] = pocket < kLeastPocket && moves > kLeastMovable;
    }
    skin.is_matched.push_back(std::move(matched));
  }
  skin.weigh_edges(generic_head.triangles);
  skin.set_pattern();
}

ElasticSkin::~ElasticSkin() = default;

double ElasticSkin::mean_distance_mm() const {
  return impl_->mean_distance_mm;
}

std::vector<Eigen::Vector3d> ElasticSkin::fit(const ScanSurface& scan, const Positions& rest,
                                              std::span<const ElasticRound> rounds,
                                              const std::string& step_name, StepKeeper* keeper) {
  Impl& skin = *impl_;
  CONTRACT(rest.size() == skin.unknown.size());
  ElasticStep state{0, 0, rest};
  const auto kept = keeper != nullptr ? keeper->find(step_name) : std::nullopt;
  if (kept && state.read(*kept)) skin.mean_distance_mm = state.mean_distance_mm;
  Positions& x = state.positions;
  int iteration = 0;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver;
  bool is_analysed = false;
  for (const ElasticRound& round : rounds) {
    CONTRACT(round.level >= 1 && round.level <= kLevels);
    for (int i = 0; i < round.iterations; ++i) {
      if (iteration++ < state.iterations) continue;
      skin.matrix.clear();
      skin.right = Eigen::VectorXd::Zero(3 * skin.matrix.rows());
      skin.add_matches(scan, x, round);
      skin.add_elasticity(x, rest, round);
      const Eigen::SparseMatrix<double> matrix = skin.matrix.assemble();
      if (!is_analysed) solver.analyzePattern(matrix);
      is_analysed = true;
      solver.factorize(matrix);
      const Eigen::VectorXd step = solver.solve(skin.right);
      if (solver.info() != Eigen::Success || !step.allFinite())
        throw NumericalFailure("the elastic fit of an expression diverged");
      for (std::size_t v = 0; v < x.size(); ++v)
        if (skin.unknown[v] >= 0) x[v] += step.segment<3>(3 * skin.unknown[v]);
      state.iterations = iteration;
      state.mean_distance_mm = skin.mean_distance_mm;
      if (keeper != nullptr) keeper->keep(step_name, state.numbers());
    }
  }
  return x;
}

}  // namespace phiz
