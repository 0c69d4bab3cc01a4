#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "stages/animate/face_layout.h"
#include "stages/animate/point4.h"

namespace phiz {

/// Stiffnesses are relative to a spring's, which is 1 for every edge.
struct SkinOptions {
  double phase_strain = 0.25;  ///< beyond this change of length a spring is stiffer
  double stiff_ratio = 3;      ///< by so much, >= 1
  double bend_mm2 = 15;        ///< resistance of the displacement against bending, springs' times mm^2
  double tie_mm = 8;           ///< skin over bone follows the bone within about so many mm
  double least_tie = 0.02;     ///< of the tie, where the anatomy leaves none
  double flesh_mm = 3;         ///< how far firm skin may be pressed towards the bone
  double volume_mm2 = 0.02;    ///< stiffness of volumes, a mm^2 of their skin
  double damping_s = 0.02;     ///< time in which strain dies away
  double density = 2e-6;       ///< mass of a mm^2, springs' times s^2
  double dissipation = 1;      ///< 1: backward Euler; 0: the midpoint rule, which keeps energy
  int rounds = 3;              ///< of the solver a step
  bool is_tied = true;         ///< false: free skin without bones, muscles and contacts
};

/// The control mesh of one subject as living skin: vertices are masses, edges biphasic springs; bone holds it
/// by soft ties and stops it; muscles pull, the jaw carries what is tied to it; cheeks keep their volume;
/// lips and lids part. Implicit steps by a quasi-Newton method whose matrix bounds the energy's curvature and
/// is factored once for a ladder of step lengths: stable at any step. At rest without activation the
/// displacement is exactly 0. Nothing is allocated after construction; deterministic; one thread.
/// Kaehler, Haber, Seidel 2001 (muscles, skin); Liu, Bouaziz, Kavan 2017 (quasi-Newton steps).
class Skin {
 public:
  /// rest: the subject's control vertices, mm. Throws InvalidInput where sizes differ. 0.3 s: matrices, and
  /// every muscle's force so that at full contraction skin goes the muscle's way.
  Skin(std::shared_ptr<const FaceLayout> layout, std::span<const Eigen::Vector3d> rest,
       const SkinOptions& options = {});
  ~Skin();
  Skin(Skin&&) noexcept;

  /// One a name of layout().activations(); cut to [0, maximum].
  void set_activations(std::span<const float> activations);
  /// Goes on by `seconds` > 0.
  void step(double seconds);
  /// To the equilibrium: no inertia, no time.
  void relax(int rounds = 60);
  void reset();  ///< rest, no velocity, no activation
  /// Velocities, mm/s (tests, throws).
  void set_velocities(std::span<const Eigen::Vector3f> velocities);

  std::span<const Eigen::Vector3f> positions() const;  ///< mm, one a control vertex
  std::span<const Eigen::Vector3f> rest_positions() const;
  const FaceLayout& layout() const;

  struct Figures {
    double kinetic = 0, elastic = 0;  ///< springs', bending, ties; springs' times mm^2
    Eigen::Vector3d momentum = Eigen::Vector3d::Zero(), angular_momentum = momentum;
    double crossing_mm = 0;  ///< how far lips or lids are through each other
    double farthest_mm = 0;  ///< any vertex from rest
  };
  Figures measure() const;
  /// Triangles outside of loose regions whose normal is turned by more than 90 degrees against rest.
  int count_turned() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace phiz
