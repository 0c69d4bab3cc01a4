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

}  // namespace phiz
