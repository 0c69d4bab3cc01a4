#pragma once

#include <memory>
#include <span>
#include <vector>

#include "stages/adapt/criteria.h"
#include "stages/deform/deform.h"

namespace phiz {

/// A subject's surface that a cascade moves, frame after frame. Fields act at the places that are asked for,
/// never on a whole level: at the points that errors are measured at (those that any field touches) and at
/// the mesh's vertices. New vertices are evaluated one by one and compiled in small groups afterwards.
class PosedSurface final : public VertexSampler {
 public:
  /// `neutral` is the surface at all vertices of the chart's level; `points` were selected on it and are
  /// moved by set_pose. Keeps references to chart and points. Throws as CompiledCascade does.
  PosedSurface(const Deformation& rig, const UvChart& chart, NeutralSurface neutral, SurfacePoints& points);
  ~PosedSurface() override;

  /// One finite number a parameter of the rig. Resample the mesh afterwards. 0.5 ms for 120,000 points.
  void set_pose(std::span<const float> parameters);
  /// Positions only: take the mesh's own normals for pictures.
  VertexSample sample(int key, const Eigen::Vector2d& uv) override;

 private:
  struct Group;
  struct Known {
    Eigen::Vector2d uv = Eigen::Vector2d::Constant(-1);
    VertexSample sample;
    unsigned pose = 0, used = 0;  ///< in which it was evaluated, and asked for, last
  };

  NeutralSurface neutral_at(std::span<const Eigen::Vector2d> uv) const;
  Eigen::Vector3f evaluate_at(const Eigen::Vector2d& uv) const;
  void gather_groups();
  void compile_group(const std::vector<int>& keys);

  const Deformation rig_;
  const UvChart& chart_;
  NeutralSurface neutral_;
  SurfacePoints& points_;
  std::vector<int> moving_;  ///< of the points
  std::unique_ptr<CompiledCascade> moving_cascade_;
  std::vector<Eigen::Vector3f> moved_;
  Cascade plain_;
  std::vector<float> parameters_;
  std::vector<double> plain_parameters_;
  std::vector<Known> known_;  ///< by key
  std::vector<int> fresh_;    ///< keys that are in no group yet
  std::vector<std::unique_ptr<Group>> groups_;
  unsigned pose_ = 0;
};

/// Indices of the places that some field of the rig may move.
std::vector<int> find_moving_places(const SampledFields& fields);

}  // namespace phiz
