#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "formats/control_mesh.h"
#include "formats/face_anatomy.h"

namespace phiz {

/// A face anatomy laid out on the generic head: which control vertices each part concerns and how much. One
/// for all subjects; shapes and directions come from each subject's own landmarks (see Skin).
class FaceLayout {
 public:
  /// Throws InvalidInput that names the part and the landmark or region that the generic head lacks, and for
  /// pairs on a head without a mirror map. 0.1 s.
  FaceLayout(const ControlMesh& generic_head, const FaceAnatomy& anatomy);

  /// What a muscle pulls.
  struct Share {
    int vertex_idx = 0;
    float influence = 0;  ///< (0, 1]
    int fibre_idx = 0;
    float along = 0;  ///< place along the fibre: 0 at the bone, 1 at the skin
  };
  struct Muscle {
    FaceMuscle shape;
    bool is_mirrored = false;
    std::vector<Share> shares;    ///< ascending vertices
    std::vector<int> retreating;  ///< vertices whose ties go back with it
    bool is_on_jaw = false;       ///< its bony end
  };
  struct Rim {
    std::string name;
    std::vector<int> upper, lower;  ///< from corner to corner, both corners in both
  };
  struct Volume {
    std::string name;
    double stiffness = 1;
    std::vector<std::pair<int, double>> shares;
  };

  const std::vector<std::string>& activations() const { return activations_; }  ///< as activation_names
  const std::vector<JawMotion>& jaw_motions() const { return jaw_; }
  const std::vector<Muscle>& muscles() const { return muscles_; }
  const std::vector<Rim>& rims() const { return rims_; }
  const std::vector<Volume>& volumes() const { return volumes_; }
  /// How firmly each vertex is tied to skull and jaw: 1 is usual.
  const std::vector<float>& skull_ties() const { return skull_ties_; }
  const std::vector<float>& jaw_ties() const { return jaw_ties_; }
  /// In a loose region: edges within it hardly pull.
  const std::vector<bool>& loose() const { return loose_; }
  const std::vector<Eigen::Vector3i>& triangles() const { return triangles_; }
  int vertex_count() const { return static_cast<int>(skull_ties_.size()); }
  float maximum(std::size_t activation_idx) const { return maxima_[activation_idx]; }

  /// A place on a subject; mirrored: of the other side.
  Eigen::Vector3d place(const LandmarkPoint& point, bool is_mirrored,
                        std::span<const Eigen::Vector3d> positions) const;
  Eigen::Vector3d condyle(bool is_left, std::span<const Eigen::Vector3d> positions) const;
  /// Activations of controls or expressions by name; null where there is none.
  const Activations* find_control(const std::string& name) const;
  const Activations* find_expression(const std::string& name) const;
  const std::map<std::string, Activations>& expressions() const { return expressions_; }
  const std::map<std::string, Activations>& controls() const { return controls_; }
  int find_activation(const std::string& name) const;  ///< -1: none

 private:
  class Builder;
  std::vector<std::string> activations_;
  std::vector<float> maxima_;
  std::vector<JawMotion> jaw_;
  std::vector<Muscle> muscles_;
  std::vector<Rim> rims_;
  std::vector<Volume> volumes_;
  std::vector<float> skull_ties_, jaw_ties_;
  std::vector<bool> loose_;
  std::vector<Eigen::Vector3i> triangles_;
  std::map<std::string, SurfacePoint> landmarks_;
  std::vector<int> mirror_;
  LandmarkPoint condyle_right_, condyle_left_;
  std::map<std::string, Activations> expressions_, controls_;
};

}  // namespace phiz
