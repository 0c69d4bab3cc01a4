#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "stages/adapt/adaptive_mesh.h"
#include "stages/adapt/face_points.h"
#include "stages/unwrap/unwrap.h"

namespace phiz {

enum class Criterion {
  kUniform,  ///< every face down to `depth`
  kNormals,  ///< angles between normals: of the two faces at the edge, and of the surface at the ends
  kContour,  ///< distance of surface and polygon at the same (u,v), over the polygon and at its edge's middle
  kDistance,  ///< distance of the surface's points to the polygon and back: for refinement in order
};

enum class ContourNorm { kMaximum, kAverage, kIntegral };

/// Errors in pixels of a picture instead of mm.
struct AdaptView {
  Eigen::Vector3f eye_mm = Eigen::Vector3f(0, 0, 600);
  float pixels_per_radian = 1000;  ///< at the picture's centre: its height / (2 tan(half the angle))
  float silhouette_gain = 3;       ///< of faces that are seen edge on
  float back_share = 0.15f;        ///< of faces that look away
};

struct CriterionOptions {
  Criterion criterion = Criterion::kContour;
  ContourNorm norm = ContourNorm::kMaximum;
  /// mm (kIntegral: mm^3; with a view: pixels). kNormals: angle x edge length / 8, which is how far an arc
  /// of that angle bulges over the edge, in mm; with `is_pure_angle` the angle itself in radians.
  double tolerance = 1.0;
  bool is_pure_angle = false;
  double shortest_mm = 0.2;  ///< kNormals splits no edge below it: creases stay creases
  int depth = 3;             ///< of kUniform, in levels: each doubles the faces
  int first_level = 0;       ///< unconditional down to it
  double hysteresis = 0.8;   ///< a weld must leave less than this share of the tolerance
  std::optional<AdaptView> view;
};

/// Where vertices get their samples.
class VertexSampler {
 public:
  virtual ~VertexSampler() = default;
  /// `key` is a small number that stays with a place of the mesh as long as it is there; -1: looked at once.
  virtual VertexSample sample(int key, const Eigen::Vector2d& uv) = 0;
};

/// The surface of a level, linear in its triangles. `normals` (one a vertex of the level) may be empty: then
/// they are the triangles'. 0.2 us a sample.
class LevelSampler final : public VertexSampler {
 public:
  LevelSampler(const UvChart& chart, std::span<const Eigen::Vector3f> positions,
               std::span<const Eigen::Vector3f> normals);
  VertexSample sample(int key, const Eigen::Vector2d& uv) override;

 private:
  const UvChart& chart_;
  std::span<const Eigen::Vector3f> positions_, normals_;
};

/// A surface over (u,v) with one of the standard criteria, for one AdaptiveMesh at a time. Keeps references;
/// positions of `points` may change between two calls of AdaptiveMesh::resample. `base_faces` as
/// locate_in_base gives them, or empty: then they are found here.
class CriterionSurface final : public AdaptiveSurface {
 public:
  CriterionSurface(const BasePolyhedron& base, VertexSampler& sampler, const SurfacePoints& points,
                   const CriterionOptions& options, std::span<const int> base_faces = {});

  const BasePolyhedron& base() const override { return base_; }
  VertexSample sample(const AdaptiveMesh& mesh, const NewVertex& place) override;
  bool should_refine(const AdaptiveMesh& mesh, int face) override;
  bool may_simplify(const AdaptiveMesh& mesh, const StellarChange& weld) override;
  double error(const AdaptiveMesh& mesh, int face) override;
  double weld_error(const AdaptiveMesh& mesh, const StellarChange& weld) override;
  void on_change(const AdaptiveMesh& mesh, const StellarChange& change) override;
  void on_resample(const AdaptiveMesh& mesh) override;
  bool is_face_local() const override { return options_.criterion != Criterion::kNormals; }

  void set_options(const CriterionOptions& options) { options_ = options; }  ///< then resample the mesh

 private:
  bool is_fresh(int face) const {
    return face < static_cast<int>(states_.size()) && states_[face].round == round_;
  }
  bool has_points() const { return faces_ != nullptr; }
  float measure(const Facet& facet, const FacePoints::Run& run, const Eigen::Vector3f& middle) const;
  float distance_to_surface(const Eigen::Vector3f& place, Eigen::Vector2d uv, double step,
                            float enough) const;
  float measure_back(const Facet& facet, float forward) const;
  const VertexSample& find_middle(const AdaptiveMesh& mesh, int face);
  float measure_normals(const AdaptiveMesh& mesh, const std::array<int, 3>& corners, int beyond) const;
  float view_factor(const Facet& facet) const;
  float importance_of(const FacePoints::Run& run) const;
  void update(const AdaptiveMesh& mesh, int face);
  bool is_still(const AdaptiveMesh& mesh, int face);
  Eigen::Vector3f mark_of(const AdaptiveMesh& mesh, int face) const;

  const BasePolyhedron& base_;
  VertexSampler& sampler_;
  const SurfacePoints& points_;
  CriterionOptions options_;
  std::unique_ptr<FacePoints> faces_;
  struct FaceState {
    float error = 0;
    bool may_move = true;                            ///< one of its points may
    unsigned round = 0;                              ///< of resampling, in which it was found; 0: not yet
    Eigen::Vector3f mark = Eigen::Vector3f::Zero();  ///< of where its corners and the middle were
    VertexSample middle;  ///< of the surface in the middle of the edge that a split would halve
  };
  unsigned round_ = 1;
  std::vector<FaceState> states_;  ///< by face slot, for criteria with points
};

}  // namespace phiz
