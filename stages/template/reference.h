#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "formats/control_mesh.h"

namespace phiz {

/// Half of a mirror-symmetric head: x <= 0 (the subject's right), a topological disk. Its border runs along
/// the mirror line (x = 0) and along the neck.
struct HalfHead {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Vector3i> triangles;
};

/// Makes a disk of a reference head: the largest piece is the skin; it is made symmetric, cut below the neck
/// plane and halved. An opening beside the mirror line (eye) is closed by a patch that lies on whatever other
/// piece is seen through it (eyeball); an opening across the mirror line (mouth) becomes a pocket. Throws
/// InvalidInput where the head is not symmetric to 1 mm, where triangles straddle the mirror line, or where
/// the result is no disk.
HalfHead close_reference(std::span<const Eigen::Vector3d> positions,
                         std::span<const Eigen::Vector3i> triangles, const Plane& neck);

}  // namespace phiz
