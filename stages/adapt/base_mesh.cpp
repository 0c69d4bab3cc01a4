#include "stages/adapt/base_mesh.h"

namespace phiz {

MadeBase make_base(std::span<const Eigen::Vector2d> uv, std::span<const Eigen::Vector3i> triangles,
                   std::span<const Eigen::Vector3d> positions, BlockOrder order) {
  MadeBase made;
  made.report = make_compliant(triangles, positions, order);
  made.polyhedron.triangles = made.report.triangles;
  made.polyhedron.uv.assign(uv.begin(), uv.end());
  for (const AddedVertex& added : made.report.added) {
    Eigen::Vector2d place = uv[added.parents[0]] + uv[added.parents[1]];
    if (added.parents[2] < 0)
      place /= 2;
    else
      place = (place + uv[added.parents[2]]) / 3;
    made.polyhedron.uv.push_back(place);
  }
  return made;
}

}  // namespace phiz
