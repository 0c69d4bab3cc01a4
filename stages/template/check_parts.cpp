#include "stages/template/check_parts.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace phiz::check_parts {
namespace {

std::vector<bool> triangles_inside(const ControlMesh& head, const std::vector<int>& region) {
  std::vector<bool> in_region(head.positions.size(), false), inside;
  for (const int v : region) in_region[v] = true;
  for (const auto& t : head.triangles)
    inside.push_back(in_region[t[0]] && in_region[t[1]] && in_region[t[2]]);
  return inside;
}

/// Whether the border of a set of triangles is one closed loop that visits no vertex twice.
bool has_simple_border(const ControlMesh& head, const std::vector<bool>& inside) {
  std::set<std::pair<int, int>> edges;
  for (std::size_t t = 0; t < inside.size(); ++t) {
    if (!inside[t]) continue;
    for (int k = 0; k < 3; ++k) {
      const int a = head.triangles[t][k], b = head.triangles[t][(k + 1) % 3];
      if (edges.erase({b, a}) == 0) edges.insert({a, b});
    }
  }
  std::map<int, int> next;
  for (const auto& [a, b] : edges) {
    if (!next.insert({a, b}).second) return false;
  }
  if (next.empty()) return false;
  std::size_t length = 1;
  for (int v = next.begin()->second; v != next.begin()->first; v = next.at(v)) ++length;
  return length == next.size();
}

/// Largest and smallest length on the surface of a unit step in (u,v).
Eigen::Vector2d stretches(const ControlMesh& head, const Eigen::Vector3i& t) {
  Eigen::Matrix2d duv;
  duv << head.uv[t[1]] - head.uv[t[0]], head.uv[t[2]] - head.uv[t[0]];
  Eigen::Matrix<double, 3, 2> dp;
  dp << head.positions[t[1]] - head.positions[t[0]], head.positions[t[2]] - head.positions[t[0]];
  const Eigen::Matrix<double, 3, 2> jacobian = dp * duv.inverse();
  return Eigen::JacobiSVD<Eigen::Matrix<double, 3, 2>>(jacobian).singularValues();
}

struct AreaSum {
  double surface = 0, square = 0, worst = 0;
  double mean() const { return std::sqrt(surface / square); }  ///< mm on the surface per unit of (u,v)
  void add(const ControlMesh& head, const Eigen::Vector3i& t) {
    surface += (head.positions[t[1]] - head.positions[t[0]])
                   .cross(head.positions[t[2]] - head.positions[t[0]])
                   .norm() /
               2;
    square += doubled_area(head.uv[t[0]], head.uv[t[1]], head.uv[t[2]]) / 2;
    worst = std::max(worst, stretches(head, t)[0]);
  }
};

void check_border(const ControlMesh& head, const HalfEdgeMesh& mesh, Report& report) {
  int off = 0, corners = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const auto& uv = head.uv[v];
    const bool on_u = uv[0] == 0 || uv[0] == 1, on_v = uv[1] == 0 || uv[1] == 1;
    off += (on_u || on_v) != mesh.is_border_vertex(v);
    corners += on_u && on_v;
  }
  report.add("vertices on the neck loop but not on the square's border, or the reverse", std::to_string(off),
             "0", off == 0);
  report.add("corners of the square with a vertex", std::to_string(corners), "4", corners == 4);
}

}  // namespace

int count_loops_around(const ControlMesh& head, const std::vector<int>& region) {
  constexpr int kMost = 8;
  std::vector<bool> left = triangles_inside(head, region);
  std::vector<std::vector<int>> triangles_at(head.positions.size());
  for (std::size_t t = 0; t < head.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) triangles_at[head.triangles[t][k]].push_back(static_cast<int>(t));
  }
  int fewest = kMost;
  bool any = false;
  for (std::size_t seed = 0; seed < left.size(); ++seed) {
    if (!left[seed]) continue;
    any = true;
    std::vector<bool> part(left.size(), false);
    std::vector<std::size_t> front = {seed};
    while (!front.empty()) {
      const std::size_t t = front.back();
      front.pop_back();
      if (!left[t]) continue;
      left[t] = false, part[t] = true;
      for (int k = 0; k < 3; ++k) {
        for (const int other : triangles_at[head.triangles[t][k]]) front.push_back(other);
      }
    }
    int loops = 0;
    while (loops < kMost && has_simple_border(head, part)) {
      ++loops;
      std::vector<bool> grown = part;
      for (std::size_t t = 0; t < part.size(); ++t) {
        for (int k = 0; part[t] && k < 3; ++k) {
          for (const int other : triangles_at[head.triangles[t][k]]) grown[other] = true;
        }
      }
      part = grown;
    }
    fewest = std::min(fewest, loops);
  }
  return any ? fewest : 0;
}

void check_annotations(const ControlMesh& head, Report& report) {
  const auto& notes = head.annotations;
  const auto missing_of = [](const auto& have, std::initializer_list<const char*> names) {
    std::string missing;
    for (const char* name : names) {
      if (!have.count(name)) missing += (missing.empty() ? "" : " ") + std::string(name);
    }
    return missing.empty() ? std::string("none") : missing;
  };
  const auto add = [&](const std::string& what, const std::string& missing) {
    report.add("missing " + what, missing, "none", missing == "none");
  };
  add("boxes", missing_of(notes.boxes, {"ear_left", "ear_right", "nose", "mouth"}));
  add("regions", missing_of(notes.regions, {"face", "lips", "inner_mouth", "eyelids", "eyes", "nostrils",
                                            "ears", "ear_left", "ear_right", "nose", "scalp", "neck"}));
  add("clipping planes", missing_of(notes.clipping_planes, {"neck", "back"}));
  add("ear landmarks", missing_of(notes.landmarks, {"ear_top_left", "tragus_left", "ear_lobe_left",
                                                    "ear_top_right", "tragus_right", "ear_lobe_right"}));
  std::map<std::string, int> groups;
  for (const auto& [name, point] : notes.landmarks) ++groups[name.substr(0, name.find('_'))];
  const int usual = groups["jaw"] + groups["chin"] + groups["brow"] + groups["nose"] + groups["subnasale"] +
                    groups["eye"] + groups["mouth"];
  report.add("landmarks of the usual 68", std::to_string(usual), "68", usual == 68);
  report.add_at_least("binding edges", static_cast<double>(notes.binding_edges.size()), 1, 0);
  report.add_at_least("constrained vertices", static_cast<double>(notes.constrained_vertices.size()), 1, 0);
}

void check_domain(const ControlMesh& head, const HalfEdgeMesh& mesh, Report& report) {
  check_border(head, mesh, report);
  int turned = 0;
  for (const auto& t : head.triangles)
    turned += !(doubled_area(head.uv[t[0]], head.uv[t[1]], head.uv[t[2]]) > 0);
  report.add("triangles turned over in (u,v)", std::to_string(turned), "0", turned == 0);
  if (turned > 0) return;
  AreaSum all, face;
  std::vector<bool> in_face(head.triangles.size(), false);
  const auto region = head.annotations.regions.find("face");
  if (region != head.annotations.regions.end()) in_face = triangles_inside(head, region->second);
  for (std::size_t t = 0; t < head.triangles.size(); ++t) {
    all.add(head, head.triangles[t]);
    if (in_face[t]) face.add(head, head.triangles[t]);
  }
  report.add("area of all triangles in (u,v)", number(all.square, 6), "1", std::abs(all.square - 1) < 1e-5);
  if (!(face.square > 0)) return;
  report.add_within("share of the square that the face has", 100 * face.square, 40, 60, 1, " %");
  report.add_at_most("mean length of a texel at 512 x 512 on the face", face.mean() / 512, 0.5, 3, " mm");
  report.add_at_most("worst stretch over the face, of its mean", face.worst / face.mean(), 4, 2);
  report.add_at_most("worst stretch over all, of its mean", all.worst / all.mean(), 20, 2);
}

}  // namespace phiz::check_parts
