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
  checks.push_back({what, value, bar, ok, picture});
}
void Report::add_at_least(const std::string& what, double value, double bar, int decimals,
                          const std::string& unit) {
  add(what, number(value, decimals) + unit, std::string(">= ").append(number(bar, decimals)) + unit,
      value >= bar);
}
void Report::add_at_most(const std::string& what, double value, double bar, int decimals,
                         const std::string& unit) {
  add(what, number(value, decimals) + unit, std::string("<= ").append(number(bar, decimals)) + unit,
      value <= bar);
}
void Report::add_within(const std::string& what, double value, double low, double high, int decimals,
                        const std::string& unit) {
  add(what, number(value, decimals) + unit, number(low, decimals) + " to " + number(high, decimals) + unit,
      value >= low && value <= high);
}
void Report::add_none(const std::string& what, std::size_t count) {
  add(what, std::to_string(count), "0", count == 0);
}
void Report::add_note(const std::string& what, const std::string& value) {
  add(what, value, "-", true);
}

}  // namespace check_parts

namespace {

using namespace check_parts;

constexpr int kFinestLevel = 4;
constexpr int kMostVertices = 20'000;  ///< larger meshes are not subdivided for a check

std::optional<HalfEdgeMesh> check_topology(const ControlMesh& head, Report& report) {
  report.picture = "wireframe";
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
  const std::size_t loops = mesh->border_loops().size();
  const int euler = n - mesh->edge_count() + mesh->triangle_count();
  report.add("borders (the neck)", std::to_string(loops), "1", loops == 1);
  report.add("one piece, a disk: Euler characteristic", std::to_string(euler), "1", euler == 1);
  if (loops != 1 || euler != 1) return std::nullopt;
  return mesh;
}

void check_connectivity(const ControlMesh& head, const HalfEdgeMesh& mesh, Report& report) {
  int interior = 0, regular = 0, lowest = mesh.vertex_count(), highest = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.is_border_vertex(v)) continue;
    const int valence = mesh.valence(v);
    ++interior, regular += valence == 6;
    lowest = std::min(lowest, valence), highest = std::max(highest, valence);
  }
  report.picture = "valences";
  report.add_at_least("interior vertices of valence 6", interior > 0 ? 100.0 * regular / interior : 0, 85, 1,
                      " %");
  const std::string range = std::to_string(lowest) + " to " + std::to_string(highest);
  report.add("valences", interior > 0 ? range : "no interior vertex", "4 to 8", lowest >= 4 && highest <= 8);
  report.picture = "angles";
  const auto angles = min_angles_deg(head.positions, head.triangles);
  report.add_at_least("smallest angle of a triangle", *std::min_element(angles.begin(), angles.end()), 15, 1,
                      " degrees");
}

void check_loops(const ControlMesh& head, Report& report) {
  struct Wanted {
    const char *region, *name;
    int loops;
  };
  report.picture = "loops";
  for (const Wanted& wanted : {Wanted{"eyes", "each eye", 3}, Wanted{"inner_mouth", "the mouth", 3},
                               Wanted{"nostrils", "each nostril", 2}}) {
    const std::string what = std::string("closed edge loops around ").append(wanted.name);
    const auto region = head.annotations.regions.find(wanted.region);
    if (region != head.annotations.regions.end()) {
      report.add_at_least(what, find_loops_around(head, region->second).fewest, wanted.loops, 0);
    } else {
      report.add_note(what, std::string("no region '").append(wanted.region).append("'"));
    }
  }
}

std::vector<double> compute_asymmetry(const ControlMesh& head) {
  const auto& mirror = head.annotations.mirror;
  std::vector<double> result;
  if (mirror.size() != head.positions.size()) return result;
  for (std::size_t v = 0; v < mirror.size(); ++v) {
    const auto &p = head.positions[v], &q = head.positions[mirror[v]];
    result.push_back((Eigen::Vector3d(-q[0], q[1], q[2]) - p).norm());
  }
  return result;
}

std::size_t count_unmirrored_triangles(const ControlMesh& head) {
  const auto& mirror = head.annotations.mirror;
  const auto turned = [](int a, int b, int c) {
    std::array<int, 3> t = {a, b, c};
    while (t[0] > t[1] || t[0] > t[2]) t = {t[1], t[2], t[0]};
    return t;
  };
  std::set<std::array<int, 3>> known;
  for (const auto& t : head.triangles) known.insert(turned(t[0], t[1], t[2]));
  std::size_t missing = 0;
  for (const auto& t : head.triangles)
    missing += known.count(turned(mirror[t[0]], mirror[t[2]], mirror[t[1]])) == 0;
  return missing;
}

void check_symmetry(const ControlMesh& head, Report& report) {
  report.picture = "symmetry";
  const auto& mirror = head.annotations.mirror;
  if (mirror.size() != head.positions.size())
    return report.add("mirror map", "missing", "one entry a vertex", false);
  const std::vector<double> asymmetry = compute_asymmetry(head);
  double worst = 0, worst_uv = 0;
  for (std::size_t v = 0; v < mirror.size(); ++v) {
    const auto &a = head.uv[v], &b = head.uv[mirror[v]];
    worst_uv = std::max({worst_uv, std::abs(a[0] + b[0] - 1), std::abs(a[1] - b[1])});
    worst = std::max(worst, asymmetry[v]);
  }
  report.add("mirror symmetry of positions", number(worst, 6) + " mm", "0", worst < 1e-9);
  report.add("mirror symmetry of (u,v)", number(worst_uv, 6), "0", worst_uv < 1e-9);
  report.add_none("triangles without mirror image", count_unmirrored_triangles(head));
  std::vector<Eigen::Vector3d> marks;
  for (const auto& [name, point] : head.annotations.landmarks)
    marks.push_back(position_at(point, head.triangles, head.positions));
  std::size_t unpaired = 0;
  for (const auto& p : marks) {
    unpaired += std::none_of(marks.begin(), marks.end(), [&](const Eigen::Vector3d& q) {
      return (Eigen::Vector3d(-q[0], q[1], q[2]) - p).norm() < 0.001;
    });
  }
  report.add_none("landmarks without mirror image", unpaired);
}

void check_limit_surface(const ControlMesh& head, Report& report) {
  report.picture = "smooth";
  const LimitSurface surface = find_limit_crossings(head, kFinestLevel);
  std::string value = std::to_string(surface.crossings.size());
  if (!surface.crossings.empty()) {
    const auto& p = surface.positions[surface.triangles[surface.crossings[0].first][0]];
    value += ", first at (" + number(p[0], 0) + ", " + number(p[1], 0) + ", " + number(p[2], 0) + ")";
  }
  report.add("crossing triangles at level 4", value, "0", surface.crossings.empty());
}

}  // namespace

LimitSurface find_limit_crossings(const ControlMesh& head, int level) {
  const SubdivisionHierarchy hierarchy(head.triangles, static_cast<int>(head.positions.size()), level);
  LimitSurface surface;
  surface.positions = evaluate_surface(hierarchy, head.positions, {}, level);
  surface.triangles = hierarchy.triangles(level);
  surface.crossings = find_self_intersections(surface.positions, surface.triangles);
  return surface;
}

std::vector<std::string> list_check_pictures() {
  return {"wireframe", "valences", "angles", "loops",   "symmetry",
          "landmarks", "regions",  "uv",     "stretch", "smooth"};
}

std::vector<HeadCheck> check_generic_head(const ControlMesh& head) {
  Report report;
  const auto mesh = check_topology(head, report);
  if (mesh) check_connectivity(head, *mesh, report);
  check_loops(head, report);
  check_symmetry(head, report);
  check_annotations(head, report);
  if (!mesh) return report.checks;
  check_domain(head, *mesh, report);
  if (head.positions.size() <= kMostVertices) check_limit_surface(head, report);
  check_order(head, report);
  return report.checks;
}

HeadMeasures measure_head(const ControlMesh& head) {
  HeadMeasures measures;
  try {
    const HalfEdgeMesh mesh(head.triangles, static_cast<int>(head.positions.size()));
    for (int v = 0; v < mesh.vertex_count(); ++v)
      measures.valences.push_back(mesh.is_border_vertex(v) ? 0 : mesh.valence(v));
  } catch (const InvalidInput&) {
    // no valences of what is no manifold
  }
  measures.min_angles_deg = min_angles_deg(head.positions, head.triangles);
  measures.asymmetry_mm = compute_asymmetry(head);
  for (const char* name : {"eyes", "inner_mouth", "nostrils"}) {
    const auto region = head.annotations.regions.find(name);
    if (region != head.annotations.regions.end())
      measures.rings[name] = find_loops_around(head, region->second).rings;
  }
  for (const auto& t : head.triangles) measures.stretches.push_back(compute_stretches(head, t));
  std::vector<bool> in_face(head.triangles.size(), true);
  const auto face = head.annotations.regions.find("face");
  if (face != head.annotations.regions.end()) in_face = find_triangles_inside(head, face->second);
  double surface = 0, square = 0;
  for (std::size_t t = 0; t < in_face.size(); ++t) {
    const auto& tri = head.triangles[t];
    const double area = doubled_area(head.uv[tri[0]], head.uv[tri[1]], head.uv[tri[2]]);
    if (in_face[t] && area > 0)
      square += area, surface += area * measures.stretches[t][0] * measures.stretches[t][1];
  }
  measures.face_mm = square > 0 ? std::sqrt(surface / square) : 0;
  return measures;
}

}  // namespace phiz
