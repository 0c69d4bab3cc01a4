#include "stages/adapt/criteria.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

constexpr float kEndless = std::numeric_limits<float>::infinity();
constexpr int kSteps = 4;         ///< towards the nearest place of the surface
constexpr float kEdgeOn = 0.25f;  ///< cosine to the line of sight below which a face may be an outline

Eigen::Vector3f normal_of(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
  return (b - a).cross(c - a).stableNormalized();
}

float angle_of_chord(float chord) {
  return 2 * std::asin(std::min(1.0f, 0.5f * chord));
}

}  // namespace

LevelSampler::LevelSampler(const UvChart& chart, std::span<const Eigen::Vector3f> positions,
                           std::span<const Eigen::Vector3f> normals)
    : chart_(chart), positions_(positions), normals_(normals) {
  CONTRACT(positions.size() == chart.uv.size() && (normals.empty() || normals.size() == positions.size()));
}

VertexSample LevelSampler::sample(int, const Eigen::Vector2d& uv) {
  const SurfacePoint place = refine_place(chart_.domain.locate(uv), chart_.level);
  const Eigen::Vector3i& t = chart_.hierarchy.triangles(chart_.level)[place.triangle_idx];
  const Eigen::Vector3f w = place.weights.cast<float>();
  VertexSample sample;
  sample.position = w[0] * positions_[t[0]] + w[1] * positions_[t[1]] + w[2] * positions_[t[2]];
  sample.normal = normals_.empty()
                      ? normal_of(positions_[t[0]], positions_[t[1]], positions_[t[2]])
                      : (w[0] * normals_[t[0]] + w[1] * normals_[t[1]] + w[2] * normals_[t[2]]).normalized();
  return sample;
}

CriterionSurface::CriterionSurface(const BasePolyhedron& base, VertexSampler& sampler,
                                   const SurfacePoints& points, const CriterionOptions& options,
                                   std::span<const int> base_faces)
    : base_(base), sampler_(sampler), points_(points), options_(options) {
  const bool needs_points =
      options.criterion == Criterion::kContour || options.criterion == Criterion::kDistance;
  if (!needs_points) return;
  if (base_faces.empty())
    faces_ = std::make_unique<FacePoints>(base, points, locate_in_base(base, points));
  else
    faces_ = std::make_unique<FacePoints>(base, points, base_faces);
}

VertexSample CriterionSurface::sample(const AdaptiveMesh&, const NewVertex& place) {
  if (has_points() && place.face >= 0) return states_[place.face].middle;  // of the edge that was split
  return sampler_.sample(2 * place.vertex, place.uv);
}

float CriterionSurface::view_factor(const Facet& facet) const {
  const auto& [a, b, c] = facet.corners;
  const Eigen::Vector3f to_eye = options_.view->eye_mm - (a + b + c) / 3;
  const float distance = std::max(1.0f, to_eye.norm());
  const float facing = normal_of(a, b, c).dot(to_eye) / distance;
  float gain = 1;
  if (std::abs(facing) < kEdgeOn)
    gain = 1 + (options_.view->silhouette_gain - 1) * (1 - std::abs(facing) / kEdgeOn);
  else if (facing < 0)
    gain = options_.view->back_share;
  return gain * options_.view->pixels_per_radian / distance;
}

float CriterionSurface::importance_of(const FacePoints::Run& run) const {
  if (points_.importance.empty()) return 1;
  float most = 0;
  for (const int point : faces_->points_in(run)) most = std::max(most, points_.importance[point]);
  return most;
}

/// Distance of a place of the facet to the surface: Gauss and Newton's steps from the same (u,v), the least
/// of what they meet. No more than `enough` is of no interest.
float CriterionSurface::distance_to_surface(const Eigen::Vector3f& place, Eigen::Vector2d uv, double step,
                                            float enough) const {
  float least = std::numeric_limits<float>::infinity();
  for (int round = 0; round < kSteps; ++round) {
    const Eigen::Vector3f here = sampler_.sample(-1, uv).position;
    least = std::min(least, (here - place).norm());
    if (least <= enough || round + 1 == kSteps) break;
    const double du = uv.x() < 0.5 ? step : -step, dv = uv.y() < 0.5 ? step : -step;
    const Eigen::Vector3d along_u =
        (sampler_.sample(-1, uv + Eigen::Vector2d(du, 0)).position - here).cast<double>() / du;
    const Eigen::Vector3d along_v =
        (sampler_.sample(-1, uv + Eigen::Vector2d(0, dv)).position - here).cast<double>() / dv;
    const Eigen::Vector3d gap = (place - here).cast<double>();
    const double uu = along_u.squaredNorm(), vv = along_v.squaredNorm(), cross = along_u.dot(along_v);
    const double det = uu * vv - cross * cross;
    if (!(det > 1e-12 * uu * vv)) break;
    const double gu = along_u.dot(gap), gv = along_v.dot(gap);
    uv += Eigen::Vector2d(vv * gu - cross * gv, uu * gv - cross * gu) / det;
    uv = uv.cwiseMax(0).cwiseMin(1);
  }
  return least;
}

/// The other way: from places of the facet to the surface. `forward` is known already.
float CriterionSurface::measure_back(const Facet& facet, float forward) const {
  constexpr std::array<std::array<float, 3>, 7> kPlaces = {{{0.5f, 0.5f, 0},
                                                            {0, 0.5f, 0.5f},
                                                            {0.5f, 0, 0.5f},
                                                            {1 / 3.0f, 1 / 3.0f, 1 / 3.0f},
                                                            {2 / 3.0f, 1 / 6.0f, 1 / 6.0f},
                                                            {1 / 6.0f, 2 / 3.0f, 1 / 6.0f},
                                                            {1 / 6.0f, 1 / 6.0f, 2 / 3.0f}}};
  const auto& [a, b, c] = facet.uv;
  const double step = 0.05 * std::sqrt(std::abs((b - a).x() * (c - a).y() - (b - a).y() * (c - a).x()));
  float worst = forward;
  for (const auto& w : kPlaces) {
    const Eigen::Vector3f place = w[0] * facet.corners[0] + w[1] * facet.corners[1] + w[2] * facet.corners[2];
    const Eigen::Vector2d uv =
        static_cast<double>(w[0]) * a + static_cast<double>(w[1]) * b + static_cast<double>(w[2]) * c;
    worst = std::max(worst, distance_to_surface(place, uv, step, worst));
  }
  return worst;
}

float CriterionSurface::measure(const Facet& facet, const FacePoints::Run& run,
                                const Eigen::Vector3f& middle) const {
  float error = 0;
  if (options_.criterion == Criterion::kDistance) {
    error = measure_back(facet, faces_->measure_distance(facet, run));
  } else if (options_.norm == ContourNorm::kMaximum) {
    error = std::max(faces_->measure_maximum(facet, run),
                     (middle - 0.5f * (facet.corners[0] + facet.corners[1])).norm());
  } else {
    const ContourError all = faces_->measure_contour(facet, run);
    error = static_cast<float>(options_.norm == ContourNorm::kAverage ? all.average_mm() : all.integral_mm3);
  }
  if (options_.view) error *= view_factor(facet);
  return error * importance_of(run);
}

/// The three edges by the surface's normals at their ends; the block's edge by the normals of its two faces
/// as well. All in squares of chords, which is what angles are nearly: most calls end without a root.
float CriterionSurface::measure_normals(const AdaptiveMesh& mesh, const std::array<int, 3>& corners,
                                        int beyond) const {
  const auto& [a, b, c] = corners;
  const Eigen::Vector3f &pa = mesh.position(a), &pb = mesh.position(b), &pc = mesh.position(c);
  const Eigen::Vector3f ab = pb - pa, ac = pc - pa;
  const float block = ab.squaredNorm();
  if (block < options_.shortest_mm * options_.shortest_mm) return 0;
  float worst = 0;
  const auto look_at = [&](float chord, float length) {
    worst = std::max(worst, options_.is_pure_angle ? chord : chord * length);
  };
  const Eigen::Vector3f &na = mesh.normal(a), &nb = mesh.normal(b), &nc = mesh.normal(c);
  look_at((na - nb).squaredNorm(), block);
  look_at((nb - nc).squaredNorm(), (pc - pb).squaredNorm());
  look_at((nc - na).squaredNorm(), ac.squaredNorm());
  const double scale = options_.is_pure_angle ? 1 : 8;
  const bool is_enough =
      !options_.view && worst > scale * scale * options_.tolerance * options_.tolerance * 1.1;
  if (beyond >= 0 && !is_enough) {
    const Eigen::Vector3f ad = mesh.position(beyond) - pa, first = ab.cross(ac), second = ad.cross(ab);
    const float sizes = first.squaredNorm() * second.squaredNorm();
    const float cosine = sizes > 0 ? first.dot(second) / std::sqrt(sizes) : 1.0f;
    const float across = std::min((ac - 0.5f * ab).squaredNorm(), (ad - 0.5f * ab).squaredNorm());
    look_at(2 - 2 * cosine, std::min(block, 4 * across));
  }
  const float root = std::sqrt(worst);
  const float error = options_.is_pure_angle ? angle_of_chord(root) : root / 8;
  return options_.view ? error * view_factor({{pa, pb, pc}, {}}) : error;
}

/// Two faces of a block share it: it is asked for once.
const VertexSample& CriterionSurface::find_middle(const AdaptiveMesh& mesh, int face) {
  VertexSample& middle = states_[face].middle;
  const int t = mesh.mesh().twin(StellarMesh::half_edge(face, 0));
  const auto& corners = mesh.mesh().corners(face);
  const int partner = t == StellarMesh::kNone || (t & 3) != 0 ? -1 : StellarMesh::face(t);
  if (partner >= 0 && is_fresh(partner))
    middle = states_[partner].middle;
  else
    middle = sampler_.sample(2 * face + 1, 0.5 * (mesh.uv(corners[0]) + mesh.uv(corners[1])));
  return middle;
}

/// A sum that changes when a corner or the middle moves.
Eigen::Vector3f CriterionSurface::mark_of(const AdaptiveMesh& mesh, int face) const {
  const auto& [a, b, c] = mesh.mesh().corners(face);
  return mesh.position(a) + 2 * mesh.position(b) + 4 * mesh.position(c) + 8 * states_[face].middle.position;
}

void CriterionSurface::update(const AdaptiveMesh& mesh, int face) {
  if (face >= static_cast<int>(states_.size())) states_.resize(mesh.mesh().face_slots());
  const auto& [a, b, c] = mesh.mesh().corners(face);
  const VertexSample& middle = find_middle(mesh, face);
  FaceState& state = states_[face];
  state.round = round_;
  state.mark = mark_of(mesh, face);
  state.error = measure(facet_of(mesh, a, b, c), faces_->run_of(face), middle.position);
  if (points_.may_move.empty()) return;
  const std::span<const int> inside = faces_->points_in(faces_->run_of(face));
  state.may_move = std::any_of(inside.begin(), inside.end(), [&](int i) { return points_.may_move[i] != 0; });
}

/// Nothing of a face that was measured in the round before has moved since.
bool CriterionSurface::is_still(const AdaptiveMesh& mesh, int face) {
  if (face >= static_cast<int>(states_.size())) return false;
  FaceState& state = states_[face];
  if (state.may_move || state.round + 1 != round_) return false;
  find_middle(mesh, face);
  if (mark_of(mesh, face) != state.mark) return false;
  state.round = round_;
  return true;
}

void CriterionSurface::on_change(const AdaptiveMesh& mesh, const StellarChange& change) {
  if (!has_points()) return;
  faces_->on_change(mesh, change);
  for (const int f : {change.f, change.n, change.g, change.m})
    if (f >= 0 && f < static_cast<int>(states_.size())) states_[f].round = 0;
  update(mesh, change.f);
  if (change.g >= 0) update(mesh, change.g);
  if (!change.is_split) return;
  update(mesh, change.n);
  if (change.m >= 0) update(mesh, change.m);
}

void CriterionSurface::on_resample(const AdaptiveMesh& mesh) {
  if (!has_points()) return;
  ++round_;
  for (int f = 0; f < mesh.mesh().face_slots(); ++f)
    if (mesh.mesh().is_face(f) && !is_still(mesh, f)) update(mesh, f);
}

double CriterionSurface::error(const AdaptiveMesh& mesh, int face) {
  if (options_.criterion == Criterion::kUniform)
    return std::max(0, options_.depth - mesh.triangulation().level(face));
  if (has_points()) return states_[face].error;
  const int t = mesh.mesh().twin(StellarMesh::half_edge(face, 0));
  const int beyond = t == StellarMesh::kNone ? -1 : mesh.mesh().from(StellarMesh::prev(t));
  return measure_normals(mesh, mesh.mesh().corners(face), beyond);
}

bool CriterionSurface::should_refine(const AdaptiveMesh& mesh, int face) {
  if (options_.criterion == Criterion::kUniform) return mesh.triangulation().level(face) < options_.depth;
  return mesh.triangulation().level(face) < options_.first_level || error(mesh, face) > options_.tolerance;
}

double CriterionSurface::weld_error(const AdaptiveMesh& mesh, const StellarChange& weld) {
  const int level = mesh.triangulation().vertex_level(weld.vertex) - 1;
  if (options_.criterion == Criterion::kUniform) return level < options_.depth ? kEndless : 0.0;
  if (level < options_.first_level) return kEndless;
  if (!has_points()) {
    const float first = measure_normals(mesh, {weld.a, weld.b, weld.c}, weld.d);
    return weld.d < 0 ? first : std::max(first, measure_normals(mesh, {weld.b, weld.a, weld.d}, weld.c));
  }
  const float first = measure(facet_of(mesh, weld.a, weld.b, weld.c), faces_->joined(weld.f, weld.n),
                              mesh.position(weld.vertex));
  if (weld.d < 0) return first;
  return std::max(first, measure(facet_of(mesh, weld.b, weld.a, weld.d), faces_->joined(weld.g, weld.m),
                                 mesh.position(weld.vertex)));
}

bool CriterionSurface::may_simplify(const AdaptiveMesh& mesh, const StellarChange& weld) {
  const double limit = options_.hysteresis * options_.tolerance;
  const bool is_plain = has_points() && !options_.view && points_.importance.empty() &&
                        options_.criterion == Criterion::kContour && options_.norm == ContourNorm::kMaximum;
  if (is_plain) {  // the vertex itself lies on the surface: most welds are refused by one look at it
    const Eigen::Vector3f middle = 0.5f * (mesh.position(weld.a) + mesh.position(weld.b));
    if ((mesh.position(weld.vertex) - middle).norm() > limit) return false;
  }
  return weld_error(mesh, weld) <= limit;
}

}  // namespace phiz
