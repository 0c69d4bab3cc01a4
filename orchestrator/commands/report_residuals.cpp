#include "orchestrator/commands/report_residuals.h"

#include <algorithm>
#include <limits>
#include <sstream>

#include "formats/image.h"
#include "formats/point_cloud.h"
#include "orchestrator/tasks/head_surface.h"
#include "stages/geometry/surface_index.h"
#include "stages/publish/views.h"

namespace phiz {
namespace {

constexpr int kLevel = 3, kTrianglesOfOne = 64;  // of a control triangle at that level
constexpr double kHeatMm = 1.0;
constexpr std::size_t kBins = 16;

Residuals summarise(std::vector<double> distances) {
  Residuals residuals;
  residuals.points = distances.size();
  if (distances.empty()) return residuals;
  std::sort(distances.begin(), distances.end());
  for (const double d : distances) residuals.mean_mm += d / static_cast<double>(distances.size());
  const auto at = [&](double share) {
    return distances[static_cast<std::size_t>(share * static_cast<double>(distances.size() - 1))];
  };
  residuals.median_mm = at(0.5);
  residuals.p95_mm = at(0.95);
  residuals.p99_mm = at(0.99);
  return residuals;
}

std::string to_png(const Image& picture) {
  std::ostringstream out;
  write_png(picture, out);
  return std::move(out).str();
}

/// Region names of each control vertex.
std::vector<std::vector<std::string>> regions_of(const ControlMesh& generic) {
  std::vector<std::vector<std::string>> names(generic.positions.size());
  for (const auto& [name, vertices] : generic.annotations.regions)
    for (const int v : vertices) names[v].push_back(name);
  return names;
}

}  // namespace

void measure_residuals(const std::string& asset_bytes, const std::string& cloud_bytes,
                       const ControlMesh& generic, SubjectReport& report) {
  std::istringstream in(cloud_bytes);
  const PointCloud cloud = read_vdb_points(in);
  const TriangleMesh mesh = evaluate_head(asset_bytes, {kLevel, false});
  report.pictures["head.png"] = to_png(draw_head(mesh));
  const SurfaceIndex surface(mesh.positions, mesh.triangles);
  const auto hits = surface.find_nearest(cloud.positions, std::numeric_limits<double>::infinity());
  const auto names = regions_of(generic);
  std::vector<double> all;
  std::map<std::string, std::vector<double>> by_region;
  std::vector<float> heat(mesh.positions.size(), 0), counts(mesh.positions.size(), 0);
  report.histogram.assign(kBins, 0);
  for (const SurfaceHit& hit : hits) {
    if (hit.triangle_idx < 0) continue;
    all.push_back(hit.distance);
    report.histogram[std::min(kBins - 1, static_cast<std::size_t>(hit.distance * 10))] += 1;
    const int corner = generic.triangles[static_cast<std::size_t>(hit.triangle_idx / kTrianglesOfOne)][0];
    if (names[corner].empty()) by_region["elsewhere"].push_back(hit.distance);
    for (const std::string& name : names[corner]) by_region[name].push_back(hit.distance);
    for (const int v : mesh.triangles[static_cast<std::size_t>(hit.triangle_idx)]) {
      heat[v] += static_cast<float>(hit.distance);
      ++counts[v];
    }
  }
  for (double& share : report.histogram) share /= static_cast<double>(std::max<std::size_t>(1, all.size()));
  for (std::size_t v = 0; v < heat.size(); ++v)
    heat[v] = counts[v] > 0 ? heat[v] / counts[v] : std::numeric_limits<float>::quiet_NaN();
  report.residuals = summarise(std::move(all));
  for (auto& [name, distances] : by_region) report.regions[name] = summarise(std::move(distances));
  std::vector<Image> views;
  for (const char* side : {"front", "threequarter", "side", "back"}) {
    ViewOptions options;
    options.camera = find_camera(side).value();
    options.heat = HeatMap{heat, 0, static_cast<float>(kHeatMm), ColourMap::kSequential, "mm"};
    options.width = 420;
    options.height = 500;
    views.push_back(render_mesh(mesh, options));
  }
  report.pictures["distances.png"] =
      to_png(contact_sheet({views}, {{"front", "threequarter", "side", "back"}}));
}

}  // namespace phiz
