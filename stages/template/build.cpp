#include <cmath>

#include "stages/geometry/error.h"
#include "stages/subdivide/subdivide.h"
#include "stages/template/annotate.h"
#include "stages/template/canonical_order.h"
#include "stages/template/improve.h"
#include "stages/template/parameterise.h"
#include "stages/template/reference.h"
#include "stages/template/separate.h"
#include "stages/template/split.h"
#include "stages/template/template.h"

namespace phiz {

MappedSurface map_reference(std::span<const Eigen::Vector3d> positions,
                            std::span<const Eigen::Vector3i> triangles, const Layout& layout) {
  const auto neck = layout.planes.find("neck");
  if (neck == layout.planes.end()) throw InvalidInput("the layout has no plane 'neck'");
  return map_half_head(close_reference(positions, triangles, neck->second), layout.scales);
}

MappedSurface map_head(const ControlMesh& head) {
  constexpr int kLevel = 2;
  const SubdivisionHierarchy hierarchy(head.triangles, static_cast<int>(head.positions.size()), kLevel);
  const auto positions = evaluate_surface(hierarchy, head.positions, {}, kLevel);
  const auto uv = evaluate_uv(hierarchy, head.uv, kLevel);
  MappedSurface half;
  std::vector<int> renamed(positions.size(), -1);
  double covered = 0;
  bool folds = false;
  for (const auto& t : hierarchy.triangles(kLevel)) {
    if (uv[t[0]][0] > 0.5 || uv[t[1]][0] > 0.5 || uv[t[2]][0] > 0.5) continue;
    Eigen::Vector3i corners;
    for (int k = 0; k < 3; ++k) {
      if (renamed[t[k]] < 0) {
        renamed[t[k]] = static_cast<int>(half.positions.size());
        half.positions.push_back(positions[t[k]]);
        half.uv.push_back(uv[t[k]]);
        if (uv[t[k]][0] == 0.5) half.positions.back()[0] = 0;
      }
      corners[k] = renamed[t[k]];
    }
    half.triangles.push_back(corners);
    const Eigen::Vector2d a = uv[t[1]] - uv[t[0]], b = uv[t[2]] - uv[t[0]];
    const double area = (a[0] * b[1] - a[1] * b[0]) / 2;
    covered += area;
    folds = folds || !(area > 0);
  }
  if (folds || std::abs(covered - 0.5) > 1e-4) {
    throw InvalidInput("the head's (u,v) does not cover the right half of the square one-to-one",
                       "phiz template check says where");
  }
  return half;
}

/// Flips and relaxation in turn, until nothing flips any more. Valences out of bounds are mended last.
void improve(HalfMesh& coarse, const SurfaceLookup& lookup, const TemplateOptions& options) {
  for (int round = 0; round < options.coarse_rounds; ++round) {
    const int flips = flip_edges(coarse, lookup);
    relax(coarse, lookup, options.coarse_sweeps);
    if (flips == 0 && round > 1) break;
  }
  FlipOptions mend;
  mend.bounds_weight = 4;
  for (int round = 0; round < options.coarse_rounds && has_odd_valences(coarse); ++round) {
    flip_edges(coarse, lookup, mend);
    relax(coarse, lookup, options.coarse_sweeps);
  }
}

constexpr double kSettledAngle_deg = 15.2;  ///< a little above what a head is checked for

ControlMesh build_generic_head(const Layout& layout, const MappedSurface& surface,
                               const TemplateOptions& options) {
  const SurfaceLookup lookup(surface);
  HalfMesh coarse = triangulate_layout(layout);
  improve(coarse, lookup, options);
  std::vector<std::vector<int>> curves;
  HalfMesh fine = split_triangles(coarse, layout, lookup, curves);
  relax(fine, lookup, options.relax_sweeps);
  ControlMesh mesh = unfold(fine, lift(fine, lookup));
  annotate(layout, fine, lookup, mesh);
  fit_limit(mesh, lookup, options.limit);
  settle(mesh, kSettledAngle_deg, options.settle_rounds);
  relax_domain(fine, mesh, options.domain);
  canonicalise_order(mesh);
  return mesh;
}

}  // namespace phiz
