#include <algorithm>
#include <cmath>

#include "stages/geometry/error.h"
#include "stages/geometry/normals.h"
#include "stages/retarget/retarget.h"

namespace phiz {
namespace {

std::vector<int> used_parameters(const ParameterTrack& track) {
  std::vector<int> used;
  for (std::size_t k = 0; k < track.parameter_count; ++k) {
    bool is_used = false;
    for (std::size_t i = 0; i < track.frame_count() && !is_used; ++i) is_used = track.frame(i)[k] != 0;
    if (is_used) used.push_back(static_cast<int>(k));
  }
  return used;
}

TriangleMesh make_mesh(const NeutralSurface& neutral, const std::vector<Eigen::Vector3i>& triangles) {
  TriangleMesh mesh;
  mesh.positions = neutral.positions;
  mesh.triangles = triangles;
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3f& p : neutral.positions) positions.push_back(p.cast<double>());
  for (const Eigen::Vector3d& n : compute_vertex_normals(positions, triangles))
    mesh.normals.push_back(n.cast<float>());
  for (const Eigen::Vector2d& uv : neutral.uv) mesh.uv.push_back(uv.cast<float>());
  return mesh;
}

}  // namespace

MotionFigures measure_motion(const CompiledCascade& cascade, const NeutralSurface& neutral,
                             const ParameterTrack& track) {
  MotionFigures figures;
  figures.frames = track.frame_count();
  std::vector<Eigen::Vector3f> positions(cascade.point_count());
  double total = 0;
  float largest = 0;
  for (std::size_t i = 0; i < track.frame_count(); ++i) {
    cascade.evaluate(track.frame(i), positions);
    float frame_largest = 0;
    double frame_sum = 0;
    for (std::size_t v = 0; v < positions.size(); ++v) {
      const float square = (positions[v] - neutral.positions[v]).squaredNorm();
      if (square == 0) continue;
      frame_largest = std::max(frame_largest, square);
      frame_sum += std::sqrt(square);
    }
    total += frame_sum;
    if (frame_largest > largest) largest = frame_largest, figures.largest_frame = i;
  }
  figures.largest_mm = std::sqrt(static_cast<double>(largest));
  figures.mean_mm = total / std::max<double>(1, static_cast<double>(positions.size() * track.frame_count()));
  return figures;
}

AnimatedMesh make_animated_mesh(const CompiledCascade& cascade, const NeutralSurface& neutral,
                                const Deformation& rig, const ParameterTrack& track,
                                const std::vector<Eigen::Vector3i>& triangles) {
  CONTRACT(track.parameter_count == rig.parameters.size());
  AnimatedMesh animated;
  animated.mesh = make_mesh(neutral, triangles);
  const std::vector<int> used = used_parameters(track);
  std::vector<Eigen::Vector3f> positions(cascade.point_count());
  for (const int k : used) {
    std::vector<float> parameters(track.parameter_count, 0.0f);
    parameters[k] = 1;
    cascade.evaluate(parameters, positions);
    MorphTarget target{rig.parameters[k].name, {}, {}};
    for (std::size_t v = 0; v < positions.size(); ++v) {
      const Eigen::Vector3f offset = positions[v] - neutral.positions[v];
      if (offset.squaredNorm() == 0) continue;
      target.vertices.push_back(static_cast<int>(v));
      target.offsets.push_back(offset);
    }
    animated.targets.push_back(std::move(target));
  }
  for (std::size_t i = 0; i < track.frame_count(); ++i) {
    animated.times_s.push_back(static_cast<float>(track.times_s[i] - track.times_s.front()));
    for (const int k : used) animated.weights.push_back(track.frame(i)[k]);
  }
  return animated;
}

double measure_morph_error(const CompiledCascade& cascade, const AnimatedMesh& mesh,
                           const ParameterTrack& track) {
  std::vector<Eigen::Vector3f> positions(cascade.point_count()), morphed;
  float largest = 0;
  for (std::size_t i = 0; i < track.frame_count(); ++i) {
    cascade.evaluate(track.frame(i), positions);
    morphed = mesh.mesh.positions;
    for (std::size_t t = 0; t < mesh.targets.size(); ++t) {
      const float weight = mesh.weights[i * mesh.targets.size() + t];
      if (weight == 0) continue;
      const MorphTarget& target = mesh.targets[t];
      for (std::size_t k = 0; k < target.vertices.size(); ++k)
        morphed[target.vertices[k]] += weight * target.offsets[k];
    }
    for (std::size_t v = 0; v < positions.size(); ++v)
      largest = std::max(largest, (positions[v] - morphed[v]).squaredNorm());
  }
  return std::sqrt(static_cast<double>(largest));
}

}  // namespace phiz
