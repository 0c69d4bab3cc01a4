#include "stages/geometry/annotations.h"

#include <algorithm>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

[[noreturn]] void refuse(std::string what) {
  throw InvalidInput("the generic head has " + std::move(what),
                     "samples/generic_head/head.json has all that is needed");
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
  for (const Eigen::Vector3i& t : generic_head.triangles)
    if (constrained[t[0]] || constrained[t[1]] || constrained[t[2]])
      hidden[t[0]] = hidden[t[1]] = hidden[t[2]] = 1;
  const auto eyes = generic_head.annotations.regions.find("eyes");
  if (eyes != generic_head.annotations.regions.end())
    for (const int v : eyes->second) hidden[v] = 1;
  return hidden;
}

}  // namespace phiz
