#include "stages/template/domain.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "stages/geometry/error.h"
#include "stages/template/parameterise.h"

namespace phiz {
namespace {

double doubled_area(const std::vector<Eigen::Vector2d>& uv, const Eigen::Vector3i& t) {
  const Eigen::Vector2d a = uv[t[1]] - uv[t[0]], b = uv[t[2]] - uv[t[0]];
  return a[0] * b[1] - a[1] * b[0];
}

/// Which triangles of the half have all their corners in a region.
std::vector<bool> find_inside(const HalfMesh& half, const ControlMesh& mesh, const char* name) {
  std::vector<bool> in_region(mesh.positions.size(), false), inside(half.triangles.size(), false);
  const auto region = mesh.annotations.regions.find(name);
  if (region == mesh.annotations.regions.end()) return inside;
  for (const int v : region->second) in_region[v] = true;
  for (std::size_t t = 0; t < inside.size(); ++t) {
    const auto& tri = half.triangles[t];
    inside[t] = in_region[tri[0]] && in_region[tri[1]] && in_region[tri[2]];
  }
  return inside;
}

/// Averages the logarithms of sizes over neighbours.
void smooth_sizes(const HalfMesh& half, std::vector<double>& sizes, int rounds) {
  std::vector<double> at_vertex(half.vertices.size());
  std::vector<int> count(half.vertices.size());
  for (int round = 0; round < rounds; ++round) {
    std::fill(at_vertex.begin(), at_vertex.end(), 0.0);
    std::fill(count.begin(), count.end(), 0);
    for (std::size_t t = 0; t < sizes.size(); ++t) {
      for (int k = 0; k < 3; ++k)
        at_vertex[half.triangles[t][k]] += std::log(sizes[t]), ++count[half.triangles[t][k]];
    }
    for (std::size_t t = 0; t < sizes.size(); ++t) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) sum += at_vertex[half.triangles[t][k]] / count[half.triangles[t][k]];
      sizes[t] = std::exp(sum / 3);
    }
  }
}

}  // namespace

void relax_domain(const HalfMesh& half, ControlMesh& mesh, const DomainOptions& options) {
  const std::size_t n = half.vertices.size();
  MappedSurface surface;
  surface.positions.assign(mesh.positions.begin(), mesh.positions.begin() + static_cast<std::ptrdiff_t>(n));
  surface.triangles = half.triangles;
  for (const auto& v : half.vertices) surface.uv.push_back(v.uv);
  const auto face = find_inside(half, mesh, "face"), ears = find_inside(half, mesh, "ears");
  const auto mouth = find_inside(half, mesh, "inner_mouth"), nostrils = find_inside(half, mesh, "nostrils");
  const auto eyes = find_inside(half, mesh, "eyes");
  double elsewhere = options.start_size;
  for (int round = 0; round < options.rounds; ++round) {
    std::vector<double> sizes;
    for (std::size_t t = 0; t < half.triangles.size(); ++t) {
      sizes.push_back(face[t] || eyes[t]        ? 1
                      : mouth[t] || nostrils[t] ? options.hidden_size
                      : ears[t]                 ? options.ear_size * std::sqrt(elsewhere)
                                                : elsewhere);
    }
    smooth_sizes(half, sizes, 2);
    relax_map(surface, sizes);
    double share = 0;
    for (std::size_t t = 0; t < face.size(); ++t)
      share += face[t] ? doubled_area(surface.uv, half.triangles[t]) : 0;
    const double odds = share / (1 - share) / (options.face_share / (1 - options.face_share));
    if (std::abs(share - options.face_share) < 0.002) break;
    elsewhere = std::clamp(elsewhere * std::pow(odds, 0.8), 0.05, 1.0);
  }
  constexpr double kGrain = 1e6;
  for (std::size_t v = 0; v < n; ++v) {
    const Eigen::Vector2d uv = (surface.uv[v] * kGrain).array().round() / kGrain;
    const int image = mesh.annotations.mirror[v];
    mesh.uv[v] = uv;
    if (image != static_cast<int>(v)) mesh.uv[image] = {std::round((1 - uv[0]) * kGrain) / kGrain, uv[1]};
  }
  for (const auto& t : mesh.triangles) {
    if (!(doubled_area(mesh.uv, t) > 0))
      throw NumericalFailure("a triangle is too thin in (u,v) for six decimals");
  }
}

}  // namespace phiz
