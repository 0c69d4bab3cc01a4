#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "stages/animate/playback.h"
#include "stages/geometry/error.h"
#include "stages/geometry/normals.h"

namespace phiz {
namespace {

constexpr std::size_t kMostSamples = 96;  ///< frames that the components are made from
constexpr double kNothingMm = 0.002;  ///< a target's offsets below it, at its largest weight, are left out

/// How far the surface is from rest, x y z one behind the other.
Eigen::VectorXf offsets_of(const std::vector<Eigen::Vector3f>& control, int level,
                           const Eigen::VectorXf& rest, LivingSurface& surface) {
  surface.evaluate(control, level);
  const auto points = surface.positions();
  Eigen::VectorXf offsets(static_cast<Eigen::Index>(3 * points.size()));
  for (std::size_t v = 0; v < points.size(); ++v)
    offsets.segment<3>(static_cast<Eigen::Index>(3 * v)) << points[v].x, points[v].y, points[v].z;
  if (rest.size() > 0) offsets -= rest;
  return offsets;
}

/// Orthonormal columns, most important first: eigenvectors of the samples' Gram matrix.
Eigen::MatrixXf find_components(const std::vector<Eigen::VectorXf>& samples, int most) {
  const auto count = static_cast<Eigen::Index>(samples.size());
  Eigen::MatrixXd gram(count, count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index k = 0; k <= i; ++k)
      gram(i, k) = gram(k, i) = samples[i].cast<double>().dot(samples[k].cast<double>());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram);
  Eigen::MatrixXf components(samples.front().size(), 0);
  for (Eigen::Index i = count - 1; i >= 0 && components.cols() < most; --i) {
    const double value = solver.eigenvalues()[i];
    if (!(value > 1e-9 * std::max(solver.eigenvalues()[count - 1], 1e-6))) break;
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(samples.front().size());
    for (Eigen::Index k = 0; k < count; ++k) sum += solver.eigenvectors()(k, i) * samples[k].cast<double>();
    components.conservativeResize(Eigen::NoChange, components.cols() + 1);
    components.rightCols(1) = (sum / std::sqrt(value)).cast<float>();
  }
  return components;
}

TriangleMesh rest_mesh(const Eigen::VectorXf& rest, const SubdivisionHierarchy& hierarchy,
                       std::span<const Eigen::Vector2f> control_uv, int level) {
  TriangleMesh mesh;
  mesh.triangles = hierarchy.triangles(level);
  for (Eigen::Index v = 0; v < rest.size() / 3; ++v) mesh.positions.push_back(rest.segment<3>(3 * v));
  mesh.normals = compute_vertex_normals(mesh.positions, mesh.triangles);
  std::vector<Eigen::Vector2d> uv;
  for (const Eigen::Vector2f& p : control_uv) uv.push_back(p.cast<double>());
  if (!uv.empty())
    for (const Eigen::Vector2d& p : evaluate_uv(hierarchy, uv, level)) mesh.uv.push_back(p.cast<float>());
  return mesh;
}

/// A component scaled so that its largest weight in the clip is 1.
MorphTarget make_target(const Eigen::VectorXf& component, float scale, int index) {
  MorphTarget target{"pose" + std::to_string(index), {}, {}};
  for (Eigen::Index v = 0; v < component.size() / 3; ++v) {
    const Eigen::Vector3f offset = scale * component.segment<3>(3 * v);
    if (offset.norm() < kNothingMm) continue;
    target.vertices.push_back(static_cast<int>(v));
    target.offsets.push_back(offset);
  }
  return target;
}

double morph_error(const Eigen::VectorXf& offsets, const std::vector<MorphTarget>& targets,
                   const float* weights) {
  Eigen::VectorXf left = offsets;
  for (std::size_t t = 0; t < targets.size(); ++t)
    for (std::size_t k = 0; k < targets[t].vertices.size(); ++k)
      left.segment<3>(3 * targets[t].vertices[k]) -= weights[t] * targets[t].offsets[k];
  double worst = 0;
  for (Eigen::Index v = 0; v < left.size() / 3; ++v)
    worst = std::max(worst, static_cast<double>(left.segment<3>(3 * v).norm()));
  return worst;
}

}  // namespace

Clip make_clip(const ControlFrames& frames, std::span<const double> times_s, LivingSurface& surface,
               const SubdivisionHierarchy& hierarchy, std::span<const Eigen::Vector2f> control_uv,
               const ClipOptions& options) {
  CONTRACT(!frames.empty() && frames.size() == times_s.size());
  CONTRACT(options.most_targets >= 1 && options.most_targets <= 128);
  const Eigen::VectorXf rest = offsets_of(frames.front(), options.level, {}, surface);
  const auto count = static_cast<Eigen::Index>(frames.size());
  std::vector<Eigen::VectorXf> samples;
  const std::size_t sample_count = std::min(frames.size(), kMostSamples);
  for (std::size_t i = 0; i < sample_count; ++i)
    samples.push_back(offsets_of(frames[i * (frames.size() - 1) / std::max<std::size_t>(sample_count - 1, 1)],
                                 options.level, rest, surface));
  Eigen::MatrixXf components = find_components(samples, options.most_targets);
  samples.clear();
  Eigen::MatrixXf weights(components.cols(), count);
  Eigen::VectorXf worst = Eigen::VectorXf::Zero(components.cols() + 1);  // with so many components
  for (Eigen::Index i = 0; i < count; ++i) {
    Eigen::VectorXf left = offsets_of(frames[i], options.level, rest, surface);
    weights.col(i) = components.transpose() * left;
    for (Eigen::Index c = 0; c <= components.cols(); ++c) {
      if (c > 0) left -= weights(c - 1, i) * components.col(c - 1);
      worst[c] = std::max(worst[c], left.reshaped(3, left.size() / 3).colwise().norm().maxCoeff());
    }
  }
  Eigen::Index used = 0;
  while (used < components.cols() && worst[used] > options.within_mm / 2) ++used;
  Clip clip;
  clip.mesh.mesh = rest_mesh(rest, hierarchy, control_uv, options.level);
  for (Eigen::Index c = 0; c < used; ++c) {
    const float scale = std::max(weights.row(c).cwiseAbs().maxCoeff(), 1e-6f);
    clip.mesh.targets.push_back(make_target(components.col(c), scale, static_cast<int>(c)));
    weights.row(c) /= scale;
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    clip.mesh.times_s.push_back(static_cast<float>(times_s[i] - times_s[0]));
    for (Eigen::Index c = 0; c < used; ++c) clip.mesh.weights.push_back(weights(c, i));
    clip.error_mm =
        std::max(clip.error_mm, morph_error(offsets_of(frames[i], options.level, rest, surface),
                                            clip.mesh.targets, clip.mesh.weights.data() + i * used));
  }
  return clip;
}

}  // namespace phiz
