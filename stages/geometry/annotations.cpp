#include "stages/geometry/annotations.h"

#include <algorithm>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

[[noreturn]] void refuse(std::string what) {
  throw InvalidInput("the generic head has " + std::move(what),
                     "samples/generic_head/head.json has all that is needed");
}

void add_neighbours(const std::vector<Eigen::Vector3i>& triangles, const std::vector<char>& of,
                    std::vector<char>& marks) {
  for (const Eigen::Vector3i& t : triangles)
    if (of[t[0]] || of[t[1]] || of[t[2]]) marks[t[0]] = marks[t[1]] = marks[t[2]] = 1;
}

std::vector<int> region_of(const ControlMesh& head, const char* name) {
  const auto region = head.annotations.regions.find(name);
  return region == head.annotations.regions.end() ? std::vector<int>{} : region->second;
}

}  // namespace

void require_annotations(const ControlMesh& generic_head) {
  for (const char* name : {"ear_left", "ear_right", "mouth", "nose"}) {
    const auto box = generic_head.annotations.boxes.find(name);
    if (box == generic_head.annotations.boxes.end()) refuse(std::string("no box '").append(name).append("'"));
    if (std::none_of(generic_head.positions.begin(), generic_head.positions.end(),
                     [&](const Eigen::Vector3d& p) { return box->second.contains(p); }))
      refuse(std::string("no vertex in its box '").append(name).append("'"));
  }
  for (const char* name : {"neck", "back"})
    if (!generic_head.annotations.clipping_planes.contains(name))
      refuse(std::string("no clipping plane '").append(name).append("'"));
}

std::vector<char> find_hidden(const ControlMesh& generic_head) {
  std::vector<char> constrained(generic_head.positions.size(), 0);
  for (const int v : generic_head.annotations.constrained_vertices) constrained[v] = 1;
  std::vector<char> hidden(constrained);
  add_neighbours(generic_head.triangles, constrained, hidden);
  for (const int v : region_of(generic_head, "eyes")) hidden[v] = 1;
  return hidden;
}

std::vector<char> find_unmeasurable(const ControlMesh& generic_head) {
  std::vector<char> unmeasurable = find_hidden(generic_head);
  std::vector<char> hem(unmeasurable.size(), 0);
  for (const int v : region_of(generic_head, "eyelids")) hem[v] = unmeasurable[v];
  add_neighbours(generic_head.triangles, hem, unmeasurable);
  return unmeasurable;
}

}  // namespace phiz
