#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/control_mesh.h"
#include "formats/point_cloud.h"
#include "formats/triangle_mesh.h"
#include "stages/subdivide/subdivide.h"

namespace phiz {

/// One named variation. A slider's value is in standard deviations, an expression's in [0,1]; at value 1 the
/// place that moves most moves by about `amplitude_mm`.
struct Variation {
  std::string name;
  double amplitude_mm = 0;
  std::string doc;
};

std::span<const Variation> list_sliders();      ///< head_width, nose_length ...
std::span<const Variation> list_expressions();  ///< jawOpen, mouthSmile, browInnerUp, mouthPucker, eyeBlink

/// The generic head evaluated to one level of subdivision, with what the variations need to know of it.
struct SubjectBase {
  std::vector<Eigen::Vector3d> positions;  ///< mm
  std::vector<Eigen::Vector3i> triangles;
  std::map<std::string, SurfacePoint> landmarks;       ///< on `triangles`
  std::map<std::string, std::vector<double>> regions;  ///< smooth weights, about 0 outside and 1 inside
  std::vector<int> neck_loop;                          ///< border vertices in order
};

/// Needs the landmarks (68-point names and ears) and the regions ears, neck, scalp, lips, inner_mouth. Throws
/// InvalidInput where one is missing or the mesh has no single border. Level in 0..5; level 3 has 90,000
/// vertices and takes 0.1 s.
SubjectBase make_subject_base(const ControlMesh& head, int level);

/// The same place of the surface, in a triangle of `level`. `point` is in a triangle of level 0.
SurfacePoint refine_surface_point(const SubdivisionHierarchy& hierarchy, int level,
                                  const SurfacePoint& point);

/// What makes a subject. An empty recipe is the generic head, bit for bit.
struct SubjectRecipe {
  std::map<std::string, double> sliders;      ///< standard deviations; those not named are 0
  std::map<std::string, double> expressions;  ///< weights
  double irregularity_mm =
      0;  ///< sigma of smooth bumps 20-45 mm wide that no slider describes, not symmetric
  std::uint64_t irregularity_seed = 0;
};

/// Sliders drawn from N(0, spread), cut off at 2.5, and 0.7 mm of irregularity; no expression.
SubjectRecipe draw_recipe(std::uint64_t seed, double spread = 1.0);

/// Positions of a subject on the triangles of `base`: same vertex, same anatomical place. Displacements are
/// smooth functions of the place on the generic head and add up. Throws InvalidInput for unknown names and
/// values that are not finite. Deterministic at any thread count. 0.1 s at level 3.
std::vector<Eigen::Vector3d> make_subject(const SubjectBase& base, const SubjectRecipe& recipe);

enum class ScanMaterial : std::uint8_t { kSkin, kHair, kEye, kCloth };

/// What stands before the scanner: a closed-looking surface with colours and one material per vertex.
struct ScanTarget {
  TriangleMesh mesh;
  std::vector<ScanMaterial> materials;
};

struct ScanTargetOptions {
  bool has_shoulders = true;  ///< continue the neck loop to shoulders and chest
  bool has_hair = true;       ///< the region scalp scans like hair
  std::uint64_t seed = 0;     ///< of skin tone and mottling
};

/// The subject's own vertices come first, in order; shoulders are appended.
ScanTarget make_scan_target(const SubjectBase& base, std::span<const Eigen::Vector3d> positions,
                            const ScanTargetOptions& options = {});

struct ScanView {
  double azimuth_deg = 0;    ///< 0 front, 90 from the subject's left
  double elevation_deg = 0;  ///< positive from above
};

/// Front, +-45, +-90, front from above, rear.
std::vector<ScanView> default_scan_views();

struct ScanOptions {
  std::vector<ScanView> views = default_scan_views();
  int points = 300'000;      ///< of the result; fewer where `spacing_mm` is given or little is seen
  double spacing_mm = 0;     ///< of the ray grid at the target; 0: from `points`
  double distance_mm = 800;  ///< camera to the middle of the target
  double baseline_mm = 250;  ///< camera to projector, to the camera's right
  double camera_limit_deg = 72, projector_limit_deg = 80;  ///< steepest incidence that is still measured
  double noise_mm = 0.15;  ///< sigma along the ray, divided by cos(incidence), at most x 3.3
  double hair_noise_mm = 1.5, eye_noise_mm = 0.4;
  double hair_loss_low = 0.70, hair_loss_high = 0.95;  ///< share of samples lost, in patches
  double eye_loss = 0.5;
  double outlier_share = 0.002;                           ///< uniform in 1.2 times the box of the samples
  double registration_deg = 0.05, registration_mm = 0.1;  ///< sigma per axis, of each view
  std::optional<Plane> cut;                               ///< what lies on its negative side is not captured
};

/// A virtual structured-light scan. A jittered grid of camera rays per view; a sample is kept where the ray
/// meets the outside of the surface first, the projector sees the place too, and neither looks too steeply.
/// Points are in the target's frame, with colours, in random order. Same target, options and seed: same
/// points, at any thread count. Throws InvalidInput: views missing, numbers out of range, nothing seen.
/// 300,000 points take about 2 s.
PointCloud scan_surface(const ScanTarget& target, const ScanOptions& options, std::uint64_t seed);

/// A random pose as scans are delivered: one of the 24 axis orientations, up to 20 degrees about a random
/// axis, up to 400 mm off, and the unit, given as units per mm. Returns scan_from_truth.
Eigen::Matrix4d draw_scan_pose(std::uint64_t seed, double units_per_mm);

/// The default cut of a capture volume: a slightly tilted plane `depth_mm` under the origin.
Plane make_capture_plane(double depth_mm, std::uint64_t seed);

}  // namespace phiz
