#include <algorithm>
#include <initializer_list>
#include <set>

#include "formats/draco_streams.h"
#include "formats/error.h"
#include "stages/geometry/error.h"
#include "stages/template/canonical_order.h"
#include "stages/template/check_parts.h"

namespace phiz::check_parts {
namespace {

std::string two_digits(int k) {
  return std::string(k < 10 ? "0" : "").append(std::to_string(k));
}

/// The 68 points that face trackers agree on, jaw from the subject's right ear to the left one.
std::vector<std::string> list_usual_landmarks() {
  std::vector<std::string> names = {"chin", "nose_tip", "subnasale"};
  const auto add = [&](const std::string& prefix, std::initializer_list<const char*> ends) {
    for (const char* end : ends) names.push_back(prefix + end);
  };
  for (int k = 0; k <= 16; ++k) {
    if (k != 8) names.push_back(std::string("jaw_").append(two_digits(k)));
  }
  add("brow_right_", {"0", "1", "2", "3", "4"});
  add("brow_left_", {"0", "1", "2", "3", "4"});
  add("nose_bridge_", {"0", "1", "2"});
  add("nose_base_", {"right_outer", "right", "left", "left_outer"});
  for (const char* side : {"eye_right_", "eye_left_"}) {
    add(side, {"outer_corner", "upper_outer", "upper_inner", "inner_corner", "lower_inner", "lower_outer"});
  }
  add("mouth_", {"right_corner", "left_corner"});
  for (int k = 1; k <= 11; ++k) {
    if (k != 6) names.push_back(std::string("mouth_outer_").append(two_digits(k)));
  }
  for (int k = 0; k <= 7; ++k) names.push_back(std::string("mouth_inner_").append(two_digits(k)));
  return names;
}

template <class Named, class List>
std::vector<std::string> find_missing(const Named& have, const List& names) {
  std::vector<std::string> missing;
  for (const auto& name : names) {
    if (!have.count(name)) missing.emplace_back(name);
  }
  return missing;
}

/// "none", "a b" or "a b and 7 more".
std::string join(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 3;
  if (names.empty()) return "none";
  std::string text = names[0];
  for (std::size_t k = 1; k < std::min(names.size(), kMost); ++k) text.append(" ").append(names[k]);
  if (names.size() > kMost) text.append(" and ").append(std::to_string(names.size() - kMost)).append(" more");
  return text;
}

void add_missing(const std::string& what, const std::vector<std::string>& missing, bool is_needed,
                 Report& report) {
  if (is_needed) {
    report.add("missing " + what, join(missing), "none", missing.empty());
  } else {
    report.add_note("missing " + what, join(missing));
  }
}

void check_boxes(const ControlMesh& head, Report& report) {
  const auto& boxes = head.annotations.boxes;
  const std::vector<std::string> wanted = {"ear_left", "ear_right", "mouth", "nose"};
  add_missing("boxes", find_missing(boxes, wanted), true, report);
  std::vector<std::string> empty;
  for (const auto& [name, box] : boxes) {
    if (std::none_of(head.positions.begin(), head.positions.end(),
                     [&inside = box](const Eigen::Vector3d& p) { return inside.contains(p); }))
      empty.push_back(name);
  }
  report.add("boxes without a vertex", join(empty), "none", empty.empty());
}

void check_landmarks(const ControlMesh& head, bool is_human, Report& report) {
  const auto& marks = head.annotations.landmarks;
  add_missing("ear landmarks (three each)",
              find_missing(marks, std::vector<std::string>{"ear_lobe_left", "ear_lobe_right", "ear_top_left",
                                                           "ear_top_right", "tragus_left", "tragus_right"}),
              is_human, report);
  add_missing("landmarks of the usual 68", find_missing(marks, list_usual_landmarks()), is_human, report);
  report.add_note("landmarks", std::to_string(marks.size()));
}

void check_regions(const ControlMesh& head, bool is_human, Report& report) {
  const auto& regions = head.annotations.regions;
  add_missing("regions that everything needs",
              find_missing(regions, std::vector<std::string>{"ears", "face", "neck", "scalp"}), true, report);
  add_missing("regions of a human face",
              find_missing(regions, std::vector<std::string>{"ear_left", "ear_right", "eyelids", "eyes",
                                                             "inner_mouth", "lips", "nose", "nostrils"}),
              is_human, report);
  std::vector<std::string> empty;
  for (const auto& [name, vertices] : regions) {
    if (vertices.empty()) empty.push_back(name);
  }
  report.add("regions without a vertex", join(empty), "none", empty.empty());
  std::vector<bool> known(head.positions.size(), false);
  for (const auto& [name, vertices] : regions) {
    for (const int v : vertices) known[v] = true;
  }
  report.add_none("vertices in no region",
                  static_cast<std::size_t>(std::count(known.begin(), known.end(), false)));
}

/// Binding edges with both ends in one of the regions.
std::size_t count_bindings(const ControlMesh& head, std::initializer_list<const char*> regions) {
  std::set<int> members;
  for (const char* name : regions) {
    const auto region = head.annotations.regions.find(name);
    if (region != head.annotations.regions.end())
      members.insert(region->second.begin(), region->second.end());
  }
  const auto& edges = head.annotations.binding_edges;
  return static_cast<std::size_t>(std::count_if(edges.begin(), edges.end(), [&](const auto& edge) {
    return members.contains(edge.first) && members.contains(edge.second);
  }));
}

void check_ties(const ControlMesh& head, bool is_human, Report& report) {
  const double behind_ears = static_cast<double>(count_bindings(head, {"ears", "ear_left", "ear_right"}));
  const double between_lips = static_cast<double>(count_bindings(head, {"lips", "inner_mouth"}));
  const auto& held = head.annotations.constrained_vertices;
  if (!is_human) {
    report.add_note("binding edges", std::to_string(head.annotations.binding_edges.size()));
    report.add_note("constrained vertices", std::to_string(held.size()));
    return;
  }
  report.add_at_least("binding edges behind the ears", behind_ears, 2, 0);
  report.add_at_least("binding edges between the lips", between_lips, 1, 0);
  const auto mouth = head.annotations.regions.find("inner_mouth");
  std::vector<int> inside;
  if (mouth != head.annotations.regions.end()) {
    std::set_intersection(held.begin(), held.end(), mouth->second.begin(), mouth->second.end(),
                          std::back_inserter(inside));
  }
  report.add_at_least("constrained vertices of the inner lips", static_cast<double>(inside.size()), 1, 0);
}

/// Whether the codec of head assets returns vertices and triangles in the order in which they are.
bool returns_from_head_codec(const ControlMesh& head) {
  constexpr double kStep_mm = 0.01, kFarthest_mm = 1e5;
  for (const auto& p : head.positions) {
    if (!(p.cwiseAbs().maxCoeff() < kFarthest_mm)) throw FormatError("positions are beyond 100 m");
  }
  LatticeMesh mesh;
  mesh.triangles = head.triangles;
  for (const auto& p : head.positions)
    mesh.positions.push_back((p / kStep_mm).array().round().matrix().cast<int>());
  for (const auto& uv : head.uv) mesh.texture.push_back((uv * 65535).array().round().matrix().cast<int>());
  const std::string bytes = encode_lattice_mesh(mesh, kStep_mm);
  const LatticeMesh back = decode_lattice_mesh(bytes, kStep_mm, head.positions.size(), head.triangles.size());
  return back.positions == mesh.positions && back.triangles == mesh.triangles && back.texture == mesh.texture;
}

}  // namespace

bool has_human_face(const ControlMesh& head) {
  const auto usual = list_usual_landmarks();
  return std::any_of(usual.begin(), usual.end(),
                     [&](const std::string& name) { return head.annotations.landmarks.contains(name); });
}

void check_annotations(const ControlMesh& head, Report& report) {
  const bool is_human = has_human_face(head);
  report.picture = "landmarks";
  check_boxes(head, report);
  add_missing("clipping planes",
              find_missing(head.annotations.clipping_planes, std::vector<std::string>{"back", "neck"}), true,
              report);
  check_landmarks(head, is_human, report);
  check_ties(head, is_human, report);
  report.picture = "regions";
  check_regions(head, is_human, report);
}

void check_order(const ControlMesh& head, Report& report) {
  report.picture = "wireframe";
  std::string value = "no";
  try {
    if (returns_from_head_codec(head)) value = "yes";
  } catch (const FormatError& error) {
    value = error.what();
  }
  report.add("head assets (sequential Draco) keep this order", value, "yes", value == "yes");
  value = "no";
  try {
    if (is_canonical_order(head)) value = "yes";
  } catch (const NumericalFailure& failure) {
    value = failure.what();
  }
  report.add_note("Draco's edgebreaker returns it, triangles sent last first", value);
}

}  // namespace phiz::check_parts
