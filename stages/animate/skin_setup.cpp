#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "stages/animate/skin_matrices.h"
#include "stages/animate/skin_state.h"
#include "stages/geometry/error.h"

namespace phiz {
namespace {

constexpr double kShortestStep = 1.0 / 480, kLongestStep = 1.0 / 12;
constexpr double kFirmTie = 0.5;     ///< from there on bone stops skin
constexpr double kRimBound = 12;     ///< curvature of a contact at a rim's vertex, in springs
constexpr double kFirstGain = 0.02;  ///< force a mm of way and mm^2, before it is known better
constexpr int kCalibrationRounds = 30, kCalibrations = 2;

Point4 narrow(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()), 0};
}

/// A fibre on a subject: places, the bony end below the skin.
std::vector<Eigen::Vector3d> make_fibre(const FaceLayout& layout, const FaceLayout::Muscle& muscle, int fibre,
                                        const SkinMatrices& matrices, std::span<const Eigen::Vector3d> rest) {
  std::vector<Eigen::Vector3d> line;
  for (const LandmarkPoint& point : muscle.shape.fibres[fibre])
    line.push_back(layout.place(point, muscle.is_mirrored, rest));
  const auto nearer = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return (a - line[0]).squaredNorm() < (b - line[0]).squaredNorm();
  };
  const auto origin = std::min_element(rest.begin(), rest.end(), nearer) - rest.begin();
  line[0] -= muscle.shape.depth_mm * matrices.normals[origin];
  return line;
}

/// Towards the bone along the fibre at a share of its length.
Eigen::Vector3d way_to_bone(const std::vector<Eigen::Vector3d>& line, double along) {
  double length = 0;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) length += (line[i + 1] - line[i]).norm();
  double left = along * length;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Eigen::Vector3d piece = line[i + 1] - line[i];
    if (left <= piece.norm() + 1e-9 || i + 2 == line.size()) return -piece.normalized();
    left -= piece.norm();
  }
  return Eigen::Vector3d::Zero();
}

/// How a muscle would move the skin at each of its shares.
std::vector<Eigen::Vector3d> wanted_ways(const FaceLayout& layout, const FaceLayout::Muscle& muscle,
                                         const SkinMatrices& matrices,
                                         std::span<const Eigen::Vector3d> rest) {
  std::vector<Eigen::Vector3d> ways;
  const FaceMuscle& shape = muscle.shape;
  if (shape.kind == FaceMuscle::Kind::kSphincter) {
    const Eigen::Vector3d from = layout.place(shape.line_from, muscle.is_mirrored, rest);
    const Eigen::Vector3d to = layout.place(shape.line_to, muscle.is_mirrored, rest);
    const Eigen::Vector3d axis = (to - from).normalized(), middle = 0.5 * (from + to);
    Eigen::Vector3d out = Eigen::Vector3d::Zero();
    for (const auto& share : muscle.shares) out += share.influence * matrices.normals[share.vertex_idx];
    out.normalize();
    for (const auto& share : muscle.shares) {
      const Eigen::Vector3d off = rest[share.vertex_idx] - middle, along = axis * axis.dot(off);
      Eigen::Vector3d across = off - along;
      across -= out * out.dot(across);  // within the face
      Eigen::Vector3d way = -shape.across * across - shape.along * along;
      if (way.norm() > shape.way_mm) way *= shape.way_mm / way.norm();
      ways.push_back(way + shape.bulge_mm * out);
    }
    return ways;
  }
  std::vector<std::vector<Eigen::Vector3d>> lines;
  for (std::size_t f = 0; f < shape.fibres.size(); ++f)
    lines.push_back(make_fibre(layout, muscle, static_cast<int>(f), matrices, rest));
  for (const auto& share : muscle.shares) {
    const double belly = 4 * share.along * (1 - share.along);
    ways.push_back(shape.way_mm * way_to_bone(lines[share.fibre_idx], share.along) +
                   shape.bulge_mm * belly * matrices.normals[share.vertex_idx]);
  }
  return ways;
}

}  // namespace

Skin::State::State(std::shared_ptr<const FaceLayout> its_layout, std::span<const Eigen::Vector3d> rest_mm,
                   const SkinOptions& its_options)
    : layout(std::move(its_layout)), options(its_options) {
  for (const Eigen::Vector3d& p : rest_mm) {
    rest.push_back(narrow(p));
    rest_positions.push_back(p.cast<float>());
  }
  positions = rest_positions;
  for (std::vector<Point4>* field :
       {&moved, &velocity, &force_, &jaw_moved_, &goal_, &start_, &gradient_, &scratch_, &shape_})
    field->assign(rest.size(), Point4{});
  condyle_left = layout->condyle(true, rest_mm);
  condyle_right = layout->condyle(false, rest_mm);
  const SkinMatrices matrices = make_skin_matrices(*layout, rest_mm, options);
  make_geometry(matrices);
  if (options.is_tied) {
    make_stops(matrices);
    make_volumes(matrices);
  }
  const SkinRims contacts(*layout, rest);
  if (options.is_tied) rims = std::make_unique<SkinRims>(contacts);
  make_factors(matrices);
  reset();
  if (options.is_tied) make_muscles(matrices, rest_mm);
}

void Skin::State::make_geometry(const SkinMatrices& matrices) {
  for (std::size_t v = 0; v < rest.size(); ++v) {
    masses.push_back(static_cast<float>(options.density * std::max(matrices.areas[v], 0.1)));
    skull_stiffness.push_back(static_cast<float>(matrices.skull[v]));
    if (matrices.jaw[v] > 0)
      jaw_ties.push_back({static_cast<int>(v), static_cast<float>(matrices.jaw[v]),
                          static_cast<float>(matrices.jaw[v] / (matrices.jaw[v] + matrices.skull[v]))});
  }
  for (std::size_t e = 0; e < matrices.edges.size(); ++e) {
    const auto& [a, b] = matrices.edges[e];
    // As add_springs computes it, so that a spring at rest pulls exactly nothing.
    const float x = rest[a].x - rest[b].x, y = rest[a].y - rest[b].y, z = rest[a].z - rest[b].z;
    springs.push_back({a, b, std::sqrt(x * x + y * y + z * z), static_cast<float>(matrices.stiffnesses[e])});
  }
  const Eigen::SparseMatrix<double, Eigen::RowMajor> rows = matrices.bending_ties;
  linear_offsets.push_back(0);
  for (int v = 0; v < static_cast<int>(rest.size()); ++v) {
    for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(rows, v); entry; ++entry) {
      linear_columns.push_back(static_cast<int>(entry.col()));
      linear_values.push_back(static_cast<float>(entry.value()));
    }
    linear_offsets.push_back(static_cast<int>(linear_columns.size()));
  }
  for (const Eigen::Vector3i& t : layout->triangles()) {
    if (layout->loose()[t[0]] && layout->loose()[t[1]] && layout->loose()[t[2]]) continue;
    const Eigen::Vector3f& corner = rest_positions[t[0]];
    visible_triangles.push_back(t);
    rest_normals.push_back((rest_positions[t[1]] - corner).cross(rest_positions[t[2]] - corner));
  }
}

void Skin::State::make_stops(const SkinMatrices& matrices) {
  for (std::size_t v = 0; v < rest.size(); ++v) {
    const double skull = layout->skull_ties()[v], jaw = layout->jaw_ties()[v];
    if (skull + jaw < kFirmTie) continue;
    const double firm = 4 * matrices.areas[v] / (options.tie_mm * options.tie_mm);
    stops.push_back({static_cast<int>(v), static_cast<float>(firm), static_cast<float>(jaw / (jaw + skull)),
                     narrow(matrices.normals[v])});
  }
}

void Skin::State::make_volumes(const SkinMatrices& matrices) {
  if (layout->volumes().size() > 8) throw InvalidInput("more than 8 volumes");
  for (const FaceLayout::Volume& part : layout->volumes()) {
    Volume volume{std::vector<Point4>(rest.size()), 0};
    double sum = 0;
    for (const auto& [v, share] : part.shares) {
      const Eigen::Vector3d gradient = share * matrices.areas[v] * matrices.normals[v];
      volume.gradient[v] = narrow(gradient);
      sum += gradient.norm();
    }
    volume.stiffness = static_cast<float>(options.volume_mm2 * part.stiffness / std::max(sum, 1e-9));
    if (volume.stiffness > 0) volumes.push_back(std::move(volume));
  }
}

Skin::State::Factor Skin::State::make_factor(const SkinMatrices& matrices, double seconds) const {
  const double damping = seconds > 0 ? options.damping_s / seconds : 0;
  std::vector<double> diagonal(rest.size(), 0.0);
  for (std::size_t v = 0; v < rest.size(); ++v)
    diagonal[v] = seconds > 0 ? masses[v] / (seconds * seconds) : 1e-9;
  for (const Stop& stop : stops) diagonal[stop.vertex] += stop.stiffness;
  if (rims)
    for (const int v : rims->vertices()) diagonal[v] += kRimBound;
  std::vector<Eigen::Triplet<double>> triplets;
  for (int v = 0; v < static_cast<int>(rest.size()); ++v) triplets.emplace_back(v, v, diagonal[v]);
  const auto size = static_cast<Eigen::Index>(rest.size());
  Eigen::SparseMatrix<double> inertia(size, size);
  inertia.setFromTriplets(triplets.begin(), triplets.end());
  Factor factor{seconds, nullptr, {}, {}};
  factor.solver = std::make_unique<BlockSolver>(Eigen::SparseMatrix<double>(
      inertia + (1 + damping) * matrices.bending_ties + (options.stiff_ratio + damping) * matrices.springs));
  const auto count = static_cast<Eigen::Index>(volumes.size());
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(count, count);
  std::vector<Point4> scratch(rest.size());
  for (Eigen::Index q = 0; q < count; ++q) {
    std::vector<Point4> response = volumes[q].gradient;
    factor.solver->solve(response.data(), scratch.data());
    for (Eigen::Index r = 0; r < count; ++r)
      for (std::size_t v = 0; v < rest.size(); ++v) {
        const Point4 &a = response[v], &b = volumes[r].gradient[v];
        system(r, q) += double{a.x} * b.x + double{a.y} * b.y + double{a.z} * b.z;
      }
    system(q, q) += 1 / double{volumes[q].stiffness};
    factor.responses.push_back(std::move(response));
  }
  if (count > 0) factor.correction = system.inverse().cast<float>();
  return factor;
}

void Skin::State::make_factors(const SkinMatrices& matrices) {
  for (double seconds = kShortestStep; seconds < kLongestStep; seconds *= std::sqrt(2.0))
    factors.push_back(make_factor(matrices, seconds));
  factors.push_back(make_factor(matrices, 0));
}

void Skin::State::make_muscles(const SkinMatrices& matrices, std::span<const Eigen::Vector3d> rest_mm) {
  const std::unique_ptr<SkinRims> kept = std::move(rims);  // contacts would hide how far a muscle reaches
  double gain = 1;
  for (const FaceLayout::Muscle& shape : layout->muscles()) {
    Muscle muscle;
    muscle.is_on_jaw = shape.is_on_jaw;
    muscle.retreating = shape.retreating;
    Eigen::Vector3d retreat = shape.shape.retreat_mm;
    if (shape.is_mirrored) retreat.x() = -retreat.x();
    muscle.retreat = narrow(retreat);
    const std::vector<Eigen::Vector3d> wanted = wanted_ways(*layout, shape, matrices, rest_mm);
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const FaceLayout::Share& share = shape.shares[i];
      const double scale =
          share.influence * matrices.areas[share.vertex_idx] * (shape.is_mirrored ? gain : kFirstGain);
      muscle.pulls.push_back({share.vertex_idx, narrow(scale * wanted[i])});
    }
    if (!shape.is_mirrored) {  // the other side's gain is the same: faces are nearly symmetric
      gain = kFirstGain * calibrate(shape, wanted, muscle);
    }
    muscles.push_back(std::move(muscle));
  }
  rims = std::unique_ptr<SkinRims>(new SkinRims(*kept));
  reset();
}

/// Scales the forces until the skin goes the wanted way: as far on average, or its farthest vertex as far as
/// the farthest wanted, whichever comes first. Returns the factor.
double Skin::State::calibrate(const FaceLayout::Muscle& shape, const std::vector<Eigen::Vector3d>& wanted,
                              Muscle& muscle) {
  double factor = 1;
  for (int turn = 0; turn < kCalibrations; ++turn) {
    reset();
    for (const Pull& pull : muscle.pulls) force_[pull.vertex] = pull.force;
    relax(kCalibrationRounds);
    double reached = 0, whole = 0, farthest = 0, wanted_farthest = 0;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const FaceLayout::Share& share = shape.shares[i];
      const double weight = std::pow(double{share.influence}, 3);
      const Point4& u = moved[share.vertex_idx];
      reached += weight * wanted[i].dot(Eigen::Vector3d(u.x, u.y, u.z));
      whole += weight * wanted[i].squaredNorm();
      farthest = std::max(farthest, Eigen::Vector3d(u.x, u.y, u.z).norm());
      wanted_farthest = std::max(wanted_farthest, wanted[i].norm());
    }
    reached = std::max(reached, whole * farthest / std::max(wanted_farthest, 1e-9));
    const auto scale = static_cast<float>(std::clamp(whole / std::max(reached, 0.02 * whole), 0.1, 10.0));
    for (Pull& pull : muscle.pulls)
      pull.force = {pull.force.x * scale, pull.force.y * scale, pull.force.z * scale, 0};
    factor *= scale;
  }
  return factor;
}

}  // namespace phiz
