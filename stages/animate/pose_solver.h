#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

namespace phiz {

/// Finds the inputs in [0, maximum] of something that poses the control mesh (a skin's activations, a rig's
/// controls) whose pose is nearest to a given one: bounded least squares over the pose's response to each
/// input alone, then again over what is left, since responses do not quite add up.
class PoseSolver {
 public:
  /// Writes the pose of inputs: one position a vertex, mm.
  using Pose = std::function<void(std::span<const float> inputs, std::vector<Eigen::Vector3f>& positions)>;

  /// Calls `pose` once an input, and for rest. `weights`: one a vertex, >= 0.
  PoseSolver(Pose pose, std::span<const float> maxima, std::vector<float> weights);

  struct Result {
    std::vector<float> inputs;
    double rms_mm = 0;       ///< of what is left, over weighted vertices
    double goal_rms_mm = 0;  ///< of the goal from rest: what rms_mm compares with
  };
  /// Displacements from rest that the pose should have. `rounds` calls of `pose`.
  Result solve(std::span<const Eigen::Vector3f> displacements_mm, int rounds = 3) const;
  const std::vector<Eigen::Vector3f>& rest() const { return rest_; }

 private:
  Eigen::VectorXd weighted(std::span<const Eigen::Vector3f> displacements) const;
  Pose pose_;
  std::vector<float> maxima_, weights_;
  std::vector<Eigen::Vector3f> rest_;
  Eigen::MatrixXd responses_;  ///< a column an input, weighted
  Eigen::MatrixXd normal_;
};

}  // namespace phiz
