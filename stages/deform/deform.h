#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "formats/control_mesh.h"
#include "formats/deformation.h"
#include "stages/deform/compiled_cascade.h"
#include "stages/subdivide/subdivide.h"

namespace phiz {

/// The local frame of a subject at a control vertex: the rotation that best carries the generic head's
/// surroundings (some 15 mm, weights by distance) to the subject's. Smooth, defined everywhere, identity on
/// the generic head; vectors of an add_local field are therefore given in the generic head's axes. Inside a
/// control triangle frames are the normalised linear blend of its corners', at any level of subdivision.
class LocalFrames {
 public:
  explicit LocalFrames(const ControlMesh& generic_head);
  /// One a control vertex, w > 0. 5 ms.
  std::vector<Eigen::Quaterniond> compute(std::span<const Eigen::Vector3d> control_positions) const;

 private:
  std::vector<Eigen::Vector3d> positions_;
  std::vector<int> offsets_, neighbours_;  ///< of each control vertex
  std::vector<double> weights_;
};

/// A subject's neutral surface at many points: what fields act on. One row each a point.
struct NeutralSurface {
  std::vector<Eigen::Vector2d> uv;
  std::vector<Eigen::Vector3f> positions;            ///< mm, head frame
  std::vector<Eigen::Matrix3f> frames;               ///< local frame: subject from generic head
  std::map<std::string, Eigen::Vector3d> landmarks;  ///< on the control mesh
};

/// Makes neutral surfaces of subjects at the vertices of one level; what depends on the generic head alone is
/// made once. Safe to use from several threads.
class NeutralMaker {
 public:
  NeutralMaker(const ControlMesh& generic_head, int level);  ///< throws InvalidInput; level 0 .. 6
  /// control_positions and displacements_mm as in HeadAsset. Positions are those of evaluate_surface, as
  /// float. Throws InvalidInput where sizes differ.
  NeutralSurface make(std::span<const Eigen::Vector3d> control_positions,
                      std::span<const std::vector<float>> displacements_mm) const;
  const SubdivisionHierarchy& hierarchy() const { return hierarchy_; }
  const std::vector<Eigen::Vector2d>& uv() const { return uv_; }
  int level() const { return level_; }

 private:
  int level_;
  Annotations annotations_;
  SubdivisionHierarchy hierarchy_;
  LocalFrames frames_;
  std::vector<Eigen::Vector2d> uv_;
};

/// A field's vector (or mask in x) at a place, and its slopes.
struct FieldSample {
  Eigen::Vector3d value = Eigen::Vector3d::Zero(), du = value, dv = value;
};
/// An analytic field, instead of an image.
using FieldFunction = std::function<FieldSample(const Eigen::Vector2d& uv)>;
using AnalyticFields = std::map<std::string, FieldFunction>;  ///< by the field's name

/// Bilinear or bicubic between the nodes; (u,v) beyond the square are those of its border.
FieldSample sample_field(const DeformationField& field, int grid_width, int grid_height,
                         const Eigen::Vector2d& uv);

/// A subject's neutral surface at one place; slopes are needed for slopes only.
struct SurfaceSample {
  Eigen::Vector2d uv = Eigen::Vector2d::Zero();
  Eigen::Vector3d position = Eigen::Vector3d::Zero(), du = position, dv = position;
  Eigen::Matrix3d frame = Eigen::Matrix3d::Identity(), frame_du = Eigen::Matrix3d::Zero(),
                  frame_dv = frame_du;
};

struct CascadePoint {
  Eigen::Vector3d position, du, dv;  ///< p(q; u,v) and its slopes
  Eigen::Matrix3Xd dq;               ///< a column a parameter
};

struct CascadePlan;    ///< the cascade of one subject, in order
struct SampledFields;  ///< see sample_fields

/// p(q; u,v) in double, field by field: plain, and what the compiled cascade is compared with. Copies what it
/// needs; const calls from several threads are safe.
class Cascade {
 public:
  /// Throws FormatError (check_deformation) and InvalidInput that names a landmark the subject lacks.
  Cascade(const Deformation& deformation, const std::map<std::string, Eigen::Vector3d>& landmarks,
          AnalyticFields analytic = {});
  ~Cascade();
  Eigen::Vector3d evaluate(std::span<const double> parameters, const SurfaceSample& place) const;
  CascadePoint differentiate(std::span<const double> parameters, const SurfaceSample& place) const;
  /// The same at point `point_idx` of a neutral surface, fields as sampled there; du and dv are not made.
  CascadePoint differentiate(std::span<const double> parameters, const SampledFields& fields,
                             const NeutralSurface& neutral, std::size_t point_idx) const;

 private:
  std::unique_ptr<const CascadePlan> plan_;
  std::shared_ptr<const Deformation> deformation_;
  AnalyticFields analytic_;
};

/// Fields at many points, zeros left out: belongs to a rig and a level, not to a subject.
struct SampledFields {
  std::size_t point_count = 0;
  std::vector<int> order;  ///< points along a curve through the square: neighbours lie close
  struct Field {
    std::vector<int> points;              ///< ascending
    std::vector<Eigen::Vector3f> values;  ///< masks in x
  };
  std::vector<Field> fields;  ///< as in the deformation
  // The same by point: entries offsets[i] .. offsets[i+1] are field indices and places in their lists.
  std::vector<int> offsets, point_fields, point_entries;
};
SampledFields sample_fields(const Deformation& deformation, std::span<const Eigen::Vector2d> uv,
                            const AnalyticFields& analytic = {});

/// Parameters from controls: sums of weights, clamped to each parameter's range.
std::vector<float> parameters_of_controls(const Deformation& deformation, std::span<const float> controls);

}  // namespace phiz
