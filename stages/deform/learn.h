#pragma once

#include <Eigen/Geometry>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "formats/control_mesh.h"
#include "formats/deformation.h"
#include "formats/head_asset.h"
#include "formats/point_cloud.h"
#include "stages/geometry/step_keeper.h"

namespace phiz {

struct LearnOptions {
  double strain = 0.05;   ///< mm^2: price of stretched skin
  double bending = 10;    ///< mm^4: of bent skin
  double hold = 0.001;    ///< price of small motions that nothing asks for
  double noise_mm = 0.5;  ///< motions below fade out, whole ones begin at twice that
};

/// One expression of one subject, relative to the neutral head.
struct LearnedExpression {
  std::vector<Eigen::Vector3d> displacements_mm;  ///< a control vertex each, neutral's head frame
  Eigen::Isometry3d scan_from_neutral = Eigen::Isometry3d::Identity();  ///< the head's motion between takes
  std::map<std::string, double> muscles;  ///< where the fit began: parameters above 0.05
  double mean_distance_mm = 0;            ///< of the fitted expression to its scan
};

/// Learns expressions from scans of one subject. The neutral head is found in the scan as a rigid whole by
/// what the expression leaves still, designed muscles (if any) make a first guess, and an elastic fit of the
/// neutral control mesh does the rest; where the scan says nothing the skin follows its surroundings.
class ExpressionLearner {
 public:
  /// `neutral` of the same generic head, `muscles` a rig over it or null. Throws InvalidInput.
  ExpressionLearner(const ControlMesh& generic_head, const HeadAsset& neutral, const Deformation* muscles,
                    const LearnOptions& options = {});
  ~ExpressionLearner();

  /// `cloud`: ingested (mm, upright, normals, confidences), its head frame within 15 mm and 10 degrees of the
  /// neutral's. Throws InvalidInput, NumericalFailure. Deterministic. 10 s for 120,000 points on one core.
  /// With a keeper an interrupted call of the same learner and cloud continues.
  LearnedExpression learn(const PointCloud& cloud, StepKeeper* keeper = nullptr) const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

/// In which axes learned vectors are kept.
enum class FieldAxes {
  kHead,   ///< the generic head's, turned as a whole to the subject: field type add
  kLocal,  ///< carried by the subject's local frames: field type add_local
};

struct FieldOptions {
  int side = 512;  ///< nodes of the grid, 16 .. 4096
  FieldAxes axes = FieldAxes::kLocal;
  bool is_symmetric = false;  ///< the mean of the expression and its mirror image
  bool is_split = false;      ///< NameLeft and NameRight with a soft border in the middle
};

/// A rig of learned expressions: one field, parameter and control a name (two where split), in a chain on the
/// neutral surface. Names as in check_deformation. `neutral` is the head the displacements belong to. Throws
/// InvalidInput: symmetric without the generic head's mirror, names twice.
Deformation make_learned_rig(const ControlMesh& generic_head, const HeadAsset& neutral,
                             const std::map<std::string, std::vector<Eigen::Vector3d>>& displacements_mm,
                             const std::string& origin, const FieldOptions& options = {});

}  // namespace phiz
