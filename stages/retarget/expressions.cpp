#include <algorithm>

#include "stages/geometry/error.h"
#include "stages/geometry/normals.h"
#include "stages/retarget/retarget.h"

namespace phiz {
namespace {

constexpr float kLeastMoveMm = 0.01f;  ///< below it a vertex stays where it is

MorphTarget make_target(const CompiledCascade& cascade, const NeutralSurface& neutral, const Deformation& rig,
                        std::size_t control, std::vector<Eigen::Vector3f>& positions) {
  std::vector<float> values(rig.controls.size(), 0.0f);
  values[control] = 1;
  cascade.evaluate(parameters_of_controls(rig, values), positions);
  MorphTarget target{rig.controls[control].name, {}, {}};
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const Eigen::Vector3f offset = positions[v] - neutral.positions[v];
    if (offset.squaredNorm() < kLeastMoveMm * kLeastMoveMm) continue;
    target.vertices.push_back(static_cast<int>(v));
    target.offsets.push_back(offset);
  }
  return target;
}

}  // namespace

AnimatedMesh make_expression_mesh(const CompiledCascade& cascade, const NeutralSurface& neutral,
                                  const Deformation& rig, const Motion* motion,
                                  const std::vector<Eigen::Vector3i>& triangles) {
  AnimatedMesh animated;
  animated.mesh.positions = neutral.positions;
  animated.mesh.triangles = triangles;
  std::vector<Eigen::Vector3d> rest;
  for (const Eigen::Vector3f& p : neutral.positions) rest.push_back(p.cast<double>());
  for (const Eigen::Vector3d& n : compute_vertex_normals(rest, triangles))
    animated.mesh.normals.push_back(n.cast<float>());
  for (const Eigen::Vector2d& uv : neutral.uv) animated.mesh.uv.push_back(uv.cast<float>());
  std::vector<Eigen::Vector3f> positions(cascade.point_count());
  for (std::size_t k = 0; k < rig.controls.size(); ++k)
    animated.targets.push_back(make_target(cascade, neutral, rig, k, positions));
  if (motion == nullptr) return animated;
  map_motion(rig, *motion);  // refuses what is not this rig's
  std::vector<int> controls;
  for (const std::string& name : motion->names) controls.push_back(find_control(rig, name));
  for (std::size_t i = 0; i < motion->frame_count(); ++i) {
    animated.times_s.push_back(static_cast<float>(motion->times_s[i] - motion->times_s.front()));
    std::vector<float> weights(rig.controls.size(), 0.0f);
    for (std::size_t k = 0; k < controls.size(); ++k)
      if (controls[k] >= 0) weights[controls[k]] = motion->frame(i)[k];
    animated.weights.insert(animated.weights.end(), weights.begin(), weights.end());
  }
  return animated;
}

}  // namespace phiz
