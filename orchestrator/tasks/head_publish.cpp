#include "orchestrator/tasks/head_publish.h"

#include <algorithm>
#include <sstream>

#include "formats/error.h"
#include "formats/head_asset.h"
#include "orchestrator/error.h"
#include "stages/subdivide/quantise.h"
#include "stages/subdivide/subdivide.h"

namespace phiz {
namespace {

constexpr int kTextureSteps = 4095, kConfidenceStep = 85, kMostLevel = 8;
constexpr double kPositionShare = 0.25;  ///< first step of control vertices, of the tolerance
constexpr double kShownStepMm = 0.25;

std::vector<Eigen::Vector3d> control_of(const HeadAsset& head) {
  std::vector<Eigen::Vector3d> control;
  for (const Eigen::Vector3f& p : head.positions) control.push_back(p.cast<double>());
  return control;
}

TriangleMesh shown_mesh(const SubdivisionHierarchy& hierarchy, const HeadAsset& head, int level) {
  TriangleMesh mesh;
  mesh.triangles = hierarchy.triangles(level);
  for (const Eigen::Vector3d& p : evaluate_surface(hierarchy, control_of(head), head.displacements_mm, level))
    mesh.positions.push_back(p.cast<float>());
  return mesh;
}

}  // namespace

PublishedHead publish_head(const std::string& asset_bytes, const HeadPublishOptions& options) {
  std::istringstream in(asset_bytes);
  HeadAsset head = read_head_asset(in);
  const int finest = std::max(0, static_cast<int>(head.displacements_mm.size()) - 1);
  PublishedHead published;
  published.level = options.level.value_or(finest);
  if (published.level < 0 || published.level > finest)
    throw UsageError("--level " + std::to_string(published.level) + " is not from 0 to " +
                     std::to_string(finest) + ": a head asset holds what was fitted");
  if (!(options.tolerance_mm >= 1e-3 && options.tolerance_mm <= 5))
    throw UsageError("--tolerance is not from 0.001 to 5 mm");
  if (options.shown_level < 0 || options.shown_level > kMostLevel)
    throw UsageError("--shown-level is not from 0 to 8");
  published.shown_level = std::min(options.shown_level, published.level);
  const SubdivisionHierarchy hierarchy(head.triangles, static_cast<int>(head.positions.size()),
                                       published.level);
  QuantiseOptions quantise;
  quantise.tolerance_mm = options.tolerance_mm;
  quantise.position_step_mm = kPositionShare * options.tolerance_mm;
  quantise.level = published.level;
  QuantisedSurface surface = quantise_surface(hierarchy, control_of(head), head.displacements_mm, quantise);
  published.hausdorff_mm = surface.hausdorff_mm;

  for (std::size_t i = 0; i < head.positions.size(); ++i)
    head.positions[i] = surface.control_positions[i].cast<float>();
  head.displacements_mm = std::move(surface.displacements_mm);
  head.confidences.resize(
      options.with_confidences ? std::min(head.confidences.size(), head.displacements_mm.size()) : 0);
  for (auto& level : head.confidences)
    for (std::uint8_t& value : level)
      value = static_cast<std::uint8_t>((value + kConfidenceStep / 2) / kConfidenceStep * kConfidenceStep);
  head.tolerance_mm = std::max(options.tolerance_mm, surface.hausdorff_mm);
  head.provenance = options.provenance;
  HeadAssetOptions file;
  file.displacement_step_mm = surface.step_mm;
  file.position_step_mm = surface.position_step_mm;
  file.texture_steps = kTextureSteps;
  file.confidence_step = kConfidenceStep;
  TriangleMesh shown;
  if (published.shown_level > 0) {
    shown = shown_mesh(hierarchy, head, published.shown_level);
    file.shown = &shown;
    file.shown_level = published.shown_level;
    file.shown_step_mm = kShownStepMm;
  }
  std::ostringstream out;
  write_head_asset(head, file, out);
  published.bytes = std::move(out).str();

  std::istringstream again(published.bytes);
  const HeadAsset copy = read_head_asset(again);
  if (evaluate_surface(hierarchy, control_of(copy), copy.displacements_mm, published.level) !=
      surface.positions)
    throw FormatError("the head asset does not give back the surface that it was made of");
  return published;
}

}  // namespace phiz
