#pragma once

#include <memory>
#include <vector>

#include "stages/animate/block_solver.h"
#include "stages/animate/skin.h"
#include "stages/animate/skin_rims.h"

namespace phiz {

struct SkinMatrices;

/// Everything of a skin in motion: the parts of Skin.
struct Skin::State {
  State(std::shared_ptr<const FaceLayout> layout, std::span<const Eigen::Vector3d> rest,
        const SkinOptions& options);

  void set_activations(std::span<const float> activations);
  void step(double seconds);
  void relax(int rounds);
  void reset();
  Figures measure() const;

  struct Spring {
    int a = 0, b = 0;
    float length = 0, stiffness = 1;
  };
  struct Pull {
    int vertex = 0;
    Point4 force;  ///< at activation 1
  };
  struct Muscle {
    std::vector<Pull> pulls;
    bool is_on_jaw = false;
    std::vector<int> retreating;
    Point4 retreat;
  };
  struct JawTie {
    int vertex = 0;
    float stiffness = 0, share = 0;  ///< of the jaw; of jaw and skull together
  };
  struct Stop {  ///< bone below firm skin
    int vertex = 0;
    float stiffness = 0, jaw_share = 0;
    Point4 normal;
  };
  struct Volume {
    std::vector<Point4> gradient;  ///< one a vertex
    float stiffness = 0;
  };
  /// A matrix for steps of at least `seconds`, and what volumes add to its inverse.
  struct Factor {
    double seconds = 0;
    std::unique_ptr<BlockSolver> solver;
    std::vector<std::vector<Point4>> responses;  ///< a volume each: A^-1 gradient
    Eigen::MatrixXf correction;                  ///< (1 / stiffness + gradient . response)^-1
  };

  std::shared_ptr<const FaceLayout> layout;
  SkinOptions options;
  std::vector<Eigen::Vector3f> rest_positions, positions;
  std::vector<Eigen::Vector3i> visible_triangles;
  std::vector<Eigen::Vector3f> rest_normals;  ///< of the visible triangles, any length
  std::vector<Point4> rest, moved, velocity;  ///< moved: displacement from rest
  std::vector<float> masses;
  std::vector<Spring> springs;
  std::vector<Muscle> muscles;
  std::vector<JawTie> jaw_ties;
  std::vector<Stop> stops;
  std::vector<Volume> volumes;
  std::vector<float> skull_stiffness;
  std::vector<int> linear_offsets, linear_columns;  ///< bending and ties, compressed rows
  std::vector<float> linear_values;
  std::vector<Factor> factors;  ///< ascending seconds; the last one without inertia
  std::unique_ptr<SkinRims> rims;
  Eigen::Vector3d condyle_left, condyle_right;

 private:
  void make_geometry(const SkinMatrices& matrices);
  void make_stops(const SkinMatrices& matrices);
  void make_volumes(const SkinMatrices& matrices);
  void make_factors(const SkinMatrices& matrices);
  Factor make_factor(const SkinMatrices& matrices, double seconds) const;
  void make_muscles(const SkinMatrices& matrices, std::span<const Eigen::Vector3d> rest_mm);
  double calibrate(const FaceLayout::Muscle& shape, const std::vector<Eigen::Vector3d>& wanted,
                   Muscle& muscle);

  void add_linear(float inertia_scale, float damping_scale);
  void add_springs(float damping_scale);
  void add_contacts();
  void improve(const Factor& factor, float scale);
  void apply_jaw(std::span<const float> activations);
  void publish();
  void mend();
  bool unturn();
  const Factor& find_factor(double seconds, float& scale) const;

  // Work of a step, kept to allocate nothing.
  std::vector<Point4> force_, jaw_moved_, goal_, start_, gradient_, scratch_, shape_;
  Eigen::Matrix3f jaw_turn_ = Eigen::Matrix3f::Identity();
};

}  // namespace phiz
