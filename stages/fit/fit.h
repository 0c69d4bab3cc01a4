#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "formats/control_mesh.h"
#include "stages/geometry/scan_surface.h"
#include "stages/subdivide/subdivide.h"

namespace phiz {

/// Control vertices of one subject in the head frame, mm: same indices as the generic head's.
using ControlPositions = std::vector<Eigen::Vector3d>;

struct LocalFitOptions {
  double reach_mm = 18.0;        ///< scan farther than this from a feature does not pull it
  double stretch_weight = 0.15;  ///< E_stretch against E_dist
  double blend_mm = 25.0;        ///< decay length of the exponential blend around a feature
  int samples = 400;             ///< places a feature is measured at
};

struct LocalFitBox {
  std::string name;
  double energy_before = 0, energy_after = 0;
  int evaluations = 0;
  bool applied = false;  ///< false: too little of the scan there, or no improvement; the feature stays
};

struct LocalFitResult {
  ControlPositions positions;
  std::vector<LocalFitBox> boxes;
};

/// Local fit of ears, nose and mouth (Jeong et al. 2002, 4.2): for each annotated box the affine transform
/// about the box centre (rotation, translation, scale) that minimises E_dist + E_stretch by Powell's method;
/// the surroundings follow by an exponential blend with the distance to the feature, so landmarks move along.
/// Paired ears keep each other's size within reason. Deterministic.
LocalFitResult fit_local(const ScanSurface& scan, const ControlMesh& generic_head,
                         const ControlPositions& aligned, const LocalFitOptions& options = {});

enum class Eyes { kAsTheScan, kOpen, kShut };

struct GlobalFitOptions {
  double smooth_weight_first = 60.0;  ///< lambda of the first round: stiff
  double smooth_weight_last = 20.0;   ///< lambda of the last stiff round
  int rounds = 8;                     ///< stiffness falls geometrically over these rounds
  int soft_rounds = 2;                ///< then the shape reached is the new rest shape and gives way
  double soft_weight = 0.05;          ///< lambda of the soft rounds
  double hidden_weight = 10.0;        ///< lambda of hems and eyes in the soft rounds: they stay as stiff
  int iterations_per_round = 3;  ///< at most; a round ends when the energy changes by less than `tolerance`
  double tolerance = 0.01;
  double binding_weight = 0.5;     ///< mu: edges behind the ears and between the lips keep their shape
  double constraint_weight = 0.5;  ///< nu: inner lips follow their surroundings
  double normal_weight_mm_first = 25.0, normal_weight_mm_last = 5.0;  ///< normals in the search for matches
  double reach_mm_first = 25.0, reach_mm_last = 3.0;                  ///< farther matches are refused
  double slide_weight = 0.07;     ///< share of E_dist that also acts along the surface
  double stretch_weight = 0.005;  ///< share of lambda against stretching of the region `face`; stiff rounds
  double neck_weight = 0.05;  ///< draws the neck loop to the plane below; 50 times that in the soft rounds
  Eyes eyes = Eyes::kAsTheScan;
  std::optional<Plane> neck;  ///< where the scan is cut at the neck (head frame)
};

/// State between two iterations: all that is needed to go on (a checkpoint).
struct GlobalFitState {
  int round = 0, iteration = 0;  ///< the next to be made
  bool eyes_shut = false;        ///< found behind the stiff rounds
  ControlPositions positions;
  ControlPositions round_start;  ///< positions when the current round began
  std::vector<double> energies;  ///< one an iteration
};

struct GlobalFitResult {
  ControlPositions positions;
  std::vector<double> energies;
  double mean_distance_mm = 0;  ///< of the matches at the end
  double matched_share = 0;     ///< share of the surface samples with a match
  bool eyes_shut = false;
};

/// Called after every iteration with what has been reached; returning false stops the fit at that point.
using GlobalFitProgress = std::function<bool(const GlobalFitState&)>;

/// Global fit of the control mesh (Jeong et al. 2002, 4.3): E_dist + lambda E_smooth + mu E_binding + nu
/// E_constraint, linearised about the matches and solved by preconditioned conjugate gradients, coarse to
/// fine. Beyond the paper: distances are measured at the vertices of the subdivided surface (Modified
/// Butterfly is linear in the control vertices), point to plane with a Geman-McClure weight; matches look for
/// like normals; rims of holes are refused; E_smooth is the thin-plate energy of the displacement from the
/// start, in the soft rounds from the shape reached before: first features find their places by stiff
/// motions, then the surface gives way along its normals. In between it is found out whether the scan's eyes
/// are shut (eyelids.h): where the scan stands in front of the eyes, both ways are tried and the shut one is
/// taken if it ends clearly nearer. At the end folds are laid flat (folds.h). `resume`
/// goes on from a checkpoint and ends in the same bytes as an uninterrupted run. Deterministic.
GlobalFitResult fit_global(const ScanSurface& scan, const ControlMesh& generic_head,
                           const SubdivisionHierarchy& hierarchy, const ControlPositions& start,
                           const GlobalFitOptions& options = {}, const GlobalFitState* resume = nullptr,
                           const GlobalFitProgress& progress = {});

}  // namespace phiz
