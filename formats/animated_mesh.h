#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"

namespace phiz {

/// Where a mesh moves to at weight 1: vertices ascending, one offset each, in the mesh's unit.
struct MorphTarget {
  std::string name;
  std::vector<int> vertices;
  std::vector<Eigen::Vector3f> offsets;
};

/// A mesh, its morph targets and their weights over time.
struct AnimatedMesh {
  TriangleMesh mesh;
  std::vector<MorphTarget> targets;
  std::vector<float> times_s;  ///< from 0, ascending; may be empty: no animation
  std::vector<float> weights;  ///< [frame * targets.size() + target]
};

/// A .glb as write_glb makes it (mm, node scaled to metres) with sparse accessors for the targets, their
/// names in `mesh.extras.targetNames`, and one animation of the weights, linear between frames. Same content,
/// same bytes. Throws FormatError: what check_mesh refuses, arrays that do not belong together, numbers that
/// are not finite, times that do not ascend.
void write_animated_glb(const AnimatedMesh& animated, std::ostream& out);

}  // namespace phiz
