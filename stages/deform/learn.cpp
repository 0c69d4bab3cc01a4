#include "stages/deform/learn.h"

#include <algorithm>
#include <cmath>

#include "stages/deform/deform.h"
#include "stages/deform/learn_elastic.h"
#include "stages/deform/learn_muscles.h"
#include "stages/deform/learn_pose.h"
#include "stages/geometry/error.h"
#include "stages/geometry/half_edge.h"
#include "stages/geometry/normals.h"

namespace phiz {
namespace {

using Positions = std::vector<Eigen::Vector3d>;

constexpr int kFinestLevel = 3, kPoseLevel = 2, kMuscleLevel = 1;
constexpr double kLeastParameter = 0.05;
constexpr double kStillMm = 0.5;
constexpr int kFadeRings = 2, kLooseRings = 2;

/// How much of a region's surface tells the head's motion. Later ones overrule earlier ones. Ears follow
/// smile and jaw by up to 2 mm: they hardly count.
constexpr std::pair<const char*, double> kStillness[] = {{"ears", 0.1},  {"nostrils", 0}, {"eyes", 0},
                                                         {"eyelids", 0}, {"lips", 0},     {"inner_mouth", 0},
                                                         {"neck", 0.5}};
constexpr double kStillnessElsewhere = 1;

/// A value a control vertex, linear in between, at `level`.
std::vector<double> refine(const SubdivisionHierarchy& hierarchy, std::vector<double> values, int level) {
  for (int k = 1; k <= level; ++k) {
    for (int v = hierarchy.vertex_count(k - 1); v < hierarchy.vertex_count(k); ++v) {
      const Eigen::Vector2i ends = hierarchy.parents(k, v);
      values.push_back(0.5 * (values[ends[0]] + values[ends[1]]));
    }
  }
  return values;
}

Positions moved(const Eigen::Isometry3d& motion, const Positions& positions) {
  Positions result;
  result.reserve(positions.size());
  for (const Eigen::Vector3d& p : positions) result.push_back(motion * p);
  return result;
}

/// Coarse to fine; the last round measures along the normals.
std::vector<ElasticRound> make_rounds(const LearnOptions& options) {
  std::vector<ElasticRound> rounds;
  double reach_mm = 15;
  for (const double stiffer : {16.0, 8.0, 4.0, 2.0}) {
    rounds.push_back(
        {1, std::max(3.0, reach_mm), stiffer * options.strain, stiffer * options.bending, options.hold, 2});
    reach_mm *= std::sqrt(0.5);
  }
  rounds.push_back({2, 3, options.strain, options.bending, options.hold, 2});
  rounds.push_back({2, 1.8, options.strain, options.bending, options.hold, 2});
  rounds.push_back({3, 1.8, options.strain, options.bending, options.hold, 2});
  return rounds;
}

}  // namespace

struct ExpressionLearner::Impl {
  const ControlMesh& head;
  SubdivisionHierarchy hierarchy;
  LearnOptions options;
  HeadAsset neutral;
  Positions control;
  Positions surface_control;  ///< with the displacement of level 0
  StillPlaces still;
  const Deformation* muscles;
  NeutralSurface muscle_surface;  ///< of kMuscleLevel
  std::vector<bool> is_skipped, is_movable;

  Impl(const ControlMesh& generic_head, const HeadAsset& asset, const Deformation* rig,
       const LearnOptions& chosen)
      : head(generic_head),
        hierarchy(generic_head.triangles, static_cast<int>(generic_head.positions.size()), kFinestLevel),
        options(chosen),
        neutral(asset),
        muscles(rig) {
    if (asset.positions.size() != head.positions.size())
      throw InvalidInput("the neutral head was fitted with another generic head");
    if (!(options.strain >= 0 && options.bending >= 0 && options.hold >= 0 && options.noise_mm >= 0))
      throw InvalidInput("a price of the elastic fit is negative");
    for (const Eigen::Vector3f& p : asset.positions) control.push_back(p.cast<double>());
    surface_control = evaluate_surface(hierarchy, control, neutral.displacements_mm, 0);
    find_still_places();
    std::vector<double> pocket(head.positions.size(), 0);
    for (const int v : head.annotations.constrained_vertices) pocket[v] = 1;
    const auto mouth = head.annotations.regions.find("inner_mouth");
    if (mouth != head.annotations.regions.end())
      for (const int v : mouth->second) pocket[v] = 1;
    for (const double share : refine(hierarchy, pocket, kMuscleLevel)) is_skipped.push_back(share > 0);
    find_movable();
    if (muscles) muscle_surface = NeutralMaker(head, kMuscleLevel).make(control, neutral.displacements_mm);
  }

  /// All but the border and the inside of the scalp: nothing moves there, and hair scans badly.
  void find_movable() {
    const int count = static_cast<int>(head.positions.size());
    const HalfEdgeMesh mesh(head.triangles, count);
    is_movable.assign(count, true);
    const auto scalp = head.annotations.regions.find("scalp");
    if (scalp != head.annotations.regions.end())
      for (const int v : scalp->second) is_movable[v] = false;
    for (int pass = 0; pass < kLooseRings; ++pass) {
      std::vector<bool> grown = is_movable;
      for (int v = 0; v < count; ++v)
        for (const int w : mesh.ring(v))
          if (is_movable[w]) grown[v] = true;
      is_movable = std::move(grown);
    }
    for (int v = 0; v < count; ++v)
      if (mesh.is_border_vertex(v)) is_movable[v] = false;
  }

  void find_still_places() {
    std::vector<double> weights(head.positions.size(), kStillnessElsewhere);
    for (const auto& [name, weight] : kStillness) {
      const auto region = head.annotations.regions.find(name);
      if (region == head.annotations.regions.end()) continue;
      for (const int v : region->second) weights[v] = weight;
    }
    still.weights = refine(hierarchy, std::move(weights), kPoseLevel);
    still.positions = evaluate_surface(hierarchy, control, neutral.displacements_mm, kPoseLevel);
    still.normals = compute_vertex_normals(std::span<const Eigen::Vector3d>(still.positions),
                                           hierarchy.triangles(kPoseLevel));
  }

  /// Control vertices as the muscles would have them, in the neutral's frame.
  Positions predict(const ScanSurface& scan, LearnedExpression& learned, StepKeeper* keeper) const {
    if (!muscles) return control;
    const MuscleGuess guess = guess_muscles(scan, *muscles, muscle_surface, hierarchy.triangles(kMuscleLevel),
                                            is_skipped, learned.scan_from_neutral, keeper);
    const Cascade cascade(*muscles, muscle_surface.landmarks);
    const SampledFields fields = sample_fields(*muscles, muscle_surface.uv);
    Positions predicted = control;
    for (std::size_t v = 0; v < control.size(); ++v)
      predicted[v] += cascade.differentiate(guess.parameters, fields, muscle_surface, v).position -
                      muscle_surface.positions[v].cast<double>();
    for (std::size_t k = 0; k < guess.parameters.size(); ++k)
      if (std::abs(guess.parameters[k]) > kLeastParameter)
        learned.muscles[muscles->parameters[k].name] = guess.parameters[k];
    return predicted;
  }

  /// Displacements of the control vertices, neutral's frame, from those that the muscles predict.
  Positions fit(const ScanSurface& scan, const Positions& predicted, LearnedExpression& learned,
                const std::string& step, StepKeeper* keeper) const {
    const Eigen::Isometry3d& motion = learned.scan_from_neutral;
    std::vector<Positions> levels;
    for (int level = 0; level <= kFinestLevel; ++level)
      levels.push_back(moved(motion, evaluate_surface(hierarchy, control, neutral.displacements_mm, level)));
    Positions rest = levels[0];
    for (std::size_t v = 0; v < rest.size(); ++v) rest[v] += motion.linear() * (predicted[v] - control[v]);
    ElasticSkin skin(head, hierarchy, std::move(levels), is_movable);
    const Positions fitted = skin.fit(scan, rest, make_rounds(options), step, keeper);
    learned.mean_distance_mm = skin.mean_distance_mm();
    const Eigen::Isometry3d back = motion.inverse();
    Positions displacements(fitted.size());
    for (std::size_t v = 0; v < fitted.size(); ++v) displacements[v] = back * fitted[v] - surface_control[v];
    return displacements;
  }

  /// 1 where a displacement is small, at the vertices of kPoseLevel.
  std::vector<double> stillness_of(const Positions& displacements) const {
    std::vector<double> shares;
    for (const Eigen::Vector3d& d : displacements)
      shares.push_back(std::pow(1 + d.squaredNorm() / (kStillMm * kStillMm), -2));
    return refine(hierarchy, std::move(shares), kPoseLevel);
  }

  /// Motions below the noise fade out: a factor from the largest motion in the surroundings.
  void fade_noise(Positions& displacements) const {
    if (!(options.noise_mm > 0)) return;
    const HalfEdgeMesh mesh(head.triangles, static_cast<int>(head.positions.size()));
    std::vector<double> sizes;
    for (const Eigen::Vector3d& d : displacements) sizes.push_back(d.norm());
    for (int pass = 0; pass < kFadeRings; ++pass) {
      std::vector<double> around = sizes;
      for (std::size_t v = 0; v < sizes.size(); ++v) {
        double sum = 0;
        const std::vector<int> ring = mesh.ring(static_cast<int>(v));
        for (const int w : ring) sum += sizes[w];
        around[v] = 0.5 * sizes[v] + 0.5 * sum / std::max<double>(1, static_cast<double>(ring.size()));
      }
      sizes = std::move(around);
    }
    for (std::size_t v = 0; v < sizes.size(); ++v) {
      const double t = std::clamp((sizes[v] - options.noise_mm) / options.noise_mm, 0.0, 1.0);
      displacements[v] *= t * t * (3 - 2 * t);
    }
  }
};

ExpressionLearner::ExpressionLearner(const ControlMesh& generic_head, const HeadAsset& neutral,
                                     const Deformation* muscles, const LearnOptions& options)
    : impl_(std::make_unique<const Impl>(generic_head, neutral, muscles, options)) {}

ExpressionLearner::~ExpressionLearner() = default;

LearnedExpression ExpressionLearner::learn(const PointCloud& cloud, StepKeeper* keeper) const {
  const Impl& self = *impl_;
  const ScanSurface scan(cloud);
  LearnedExpression learned;
  learned.scan_from_neutral = find_rigid_motion(scan, self.still);
  const Positions predicted = self.predict(scan, learned, keeper);
  Positions& displacements = learned.displacements_mm;
  displacements = self.fit(scan, predicted, learned, "first fit", keeper);
  // What the first fit saw moving, along the surface too, does not tell the head's motion.
  StillPlaces still = self.still;
  const std::vector<double> stillness = self.stillness_of(displacements);
  for (std::size_t i = 0; i < still.weights.size(); ++i) still.weights[i] *= stillness[i];
  learned.scan_from_neutral = find_rigid_motion(scan, still, learned.scan_from_neutral);
  displacements = self.fit(scan, predicted, learned, "second fit", keeper);

  // What is left of a rigid motion is the head's own.
  Positions moved_control = self.surface_control;
  for (std::size_t v = 0; v < moved_control.size(); ++v) moved_control[v] += displacements[v];
  std::vector<double> weights(still.weights.begin(), still.weights.begin() + moved_control.size());
  const Eigen::Isometry3d rigid = find_common_motion(self.surface_control, moved_control, weights);
  learned.scan_from_neutral = learned.scan_from_neutral * rigid;
  const Eigen::Isometry3d back = rigid.inverse();
  for (std::size_t v = 0; v < moved_control.size(); ++v)
    displacements[v] = back * moved_control[v] - self.surface_control[v];
  self.fade_noise(displacements);
  return learned;
}

}  // namespace phiz
