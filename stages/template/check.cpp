#include "stages/template/check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>

#include "stages/geometry/error.h"
#include "stages/geometry/half_edge.h"
#include "stages/subdivide/subdivide.h"
#include "stages/template/canonical_order.h"
#include "stages/template/check_parts.h"
#include "stages/template/improve.h"
#include "stages/template/self_intersection.h"

namespace phiz {
namespace check_parts {

std::string number(double x, int decimals) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%.*f", decimals, x);
  return text.data();
}

void Report::add(const std::string& what, const std::string& value, const std::string& bar, bool ok) {
  checks.push_back({what, value, bar, ok});
}
void Report::add_at_least(const std::string& what, double value, double bar, int decimals,
                          const std::string& unit) {
  add(what, number(value, decimals) + unit, ">= " + number(bar, decimals) + unit, value >= bar);
}
void Report::add_at_most(const std::string& what, double value, double bar, int decimals,
                         const std::string& unit) {
  add(what, number(value, decimals) + unit, "<= " + number(bar, decimals) + unit, value <= bar);
}
void Report::add_within(const std::string& what, double value, double low, double high, int decimals,
                        const std::string& unit) {
  add(what, number(value, decimals) + unit, number(low, decimals) + " to " + number(high, decimals) + unit,
      value >= low && value <= high);
}

}  // namespace check_parts

namespace {

using namespace check_parts;

std::optional<HalfEdgeMesh> check_topology(const ControlMesh& head, Report& report) {
  const int n = static_cast<int>(head.positions.size());
  report.add_within("vertices", n, 1000, 1600, 0);
  std::optional<HalfEdgeMesh> mesh;
  try {
    mesh.emplace(head.triangles, n);
    report.add("oriented manifold", "yes", "yes", true);
  } catch (const InvalidInput& error) {
    report.add("oriented manifold", error.what(), "yes", false);
    return std::nullopt;
  }
  const int loops = static_cast<int>(mesh->border_loops().size());
  const int euler = n - mesh->edge_count() + mesh->triangle_count();
  report.add("borders (the neck)", std::to_string(loops), "1", loops == 1);
  report.add("one piece, a disk: Euler characteristic", std::to_string(euler), "1", euler == 1);
  if (loops != 1 || euler != 1) return std::nullopt;
  return mesh;
}

void check_connectivity(const ControlMesh& head, const HalfEdgeMesh& mesh, Report& report) {
  int interior = 0, regular = 0, lowest = 1000, highest = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.is_border_vertex(v)) continue;
    const int valence = mesh.valence(v);
    ++interior, regular += valence == 6;
    lowest = std::min(lowest, valence), highest = std::max(highest, valence);
  }
  report.add_at_least("interior vertices of valence 6", 100.0 * regular / interior, 85, 1, " %");
  report.add("valences", std::to_string(lowest) + " to " + std::to_string(highest), "4 to 8",
             lowest >= 4 && highest <= 8);
  const auto angles = min_angles_deg(head.positions, head.triangles);
  report.add_at_least("smallest angle", *std::min_element(angles.begin(), angles.end()), 15, 1, " degrees");
  for (const char* name : {"eyes", "inner_mouth"}) {
    const auto region = head.annotations.regions.find(name);
    if (region == head.annotations.regions.end()) continue;
    report.add_at_least("closed edge loops around each part of '" + std::string(name) + "'",
                        count_loops_around(head, region->second), 3, 0);
  }
}

void check_symmetry(const ControlMesh& head, Report& report) {
  const auto& mirror = head.annotations.mirror;
  const std::size_t n = head.positions.size();
  if (mirror.size() != n) return report.add("mirror map", "missing", "one entry a vertex", false);
  double worst_position = 0, worst_uv = 0;
  for (std::size_t v = 0; v < n; ++v) {
    const auto &p = head.positions[v], &q = head.positions[mirror[v]];
    worst_position = std::max(worst_position, (Eigen::Vector3d(-q[0], q[1], q[2]) - p).cwiseAbs().maxCoeff());
    const auto &a = head.uv[v], &b = head.uv[mirror[v]];
    worst_uv = std::max({worst_uv, std::abs(a[0] + b[0] - 1), std::abs(a[1] - b[1])});
  }
  std::set<std::array<int, 3>> known;
  const auto sorted = [](int a, int b, int c) {
    std::array<int, 3> t = {a, b, c};
    while (t[0] > t[1] || t[0] > t[2]) t = {t[1], t[2], t[0]};
    return t;
  };
  for (const auto& t : head.triangles) known.insert(sorted(t[0], t[1], t[2]));
  int missing = 0;
  for (const auto& t : head.triangles)
    missing += known.count(sorted(mirror[t[0]], mirror[t[2]], mirror[t[1]])) == 0;
  report.add("mirror symmetry of positions", number(worst_position, 9) + " mm", "0", worst_position < 1e-9);
  report.add("mirror symmetry of (u,v)", number(worst_uv, 9), "0", worst_uv < 1e-9);
  report.add("triangles without mirror image", std::to_string(missing), "0", missing == 0);
}

void check_limit_surface(const ControlMesh& head, Report& report) {
  constexpr int kLevel = 4;
  const SubdivisionHierarchy hierarchy(head.triangles, static_cast<int>(head.positions.size()), kLevel);
  const auto positions = evaluate_surface(hierarchy, head.positions, {}, kLevel);
  const auto& triangles = hierarchy.triangles(kLevel);
  const auto crossings = find_self_intersections(positions, triangles);
  std::string value = std::to_string(crossings.size());
  if (!crossings.empty()) {
    const auto& p = positions[triangles[crossings[0].first][0]];
    value += ", first at (" + number(p[0], 0) + ", " + number(p[1], 0) + ", " + number(p[2], 0) + ")";
  }
  report.add("crossing triangles at level 4", value, "0", crossings.empty());
  const auto uv = evaluate_uv(hierarchy, head.uv, kLevel);
  int turned = 0;
  for (const auto& t : triangles) turned += !(doubled_area(uv[t[0]], uv[t[1]], uv[t[2]]) > 0);
  report.add("triangles turned over in (u,v) at level 4", std::to_string(turned), "0", turned == 0);
}

void check_order(const ControlMesh& head, Report& report) {
  std::string value = "no";
  try {
    if (is_canonical_order(head)) value = "yes";
  } catch (const NumericalFailure& failure) {
    value = failure.what();
  }
  report.add("Draco's edgebreaker returns this vertex order", value, "yes", value == "yes");
}

}  // namespace

std::vector<HeadCheck> check_generic_head(const ControlMesh& head) {
  Report report;
  const auto mesh = check_topology(head, report);
  if (!mesh) return report.checks;
  check_connectivity(head, *mesh, report);
  check_symmetry(head, report);
  check_annotations(head, report);
  check_domain(head, *mesh, report);
  check_limit_surface(head, report);
  check_order(head, report);
  return report.checks;
}

}  // namespace phiz
