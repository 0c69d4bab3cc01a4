#pragma once

#include <Eigen/Core>
#include <vector>

#include "formats/control_mesh.h"

namespace phiz {

/// Shuts the eyes of a head on the generic head's control vertices, by its annotations: a component of the
/// region `eyes` is an eye, the constrained vertices on it are the inner loop of its lids.
class Eyelids {
 public:
  using Positions = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

  /// Finds the eyes; a head without annotated eyes has none. O(vertices + triangles).
  explicit Eyelids(const ControlMesh& generic_head);

  int eye_count() const { return static_cast<int>(eyes_.size()); }

  /// Vertices that shutting the eye may move, ascending.
  const std::vector<int>& moved(int eye) const { return eyes_[eye].moved; }

  /// Vertices of the eye inside its lids, ascending.
  const std::vector<int>& inside(int eye) const { return eyes_[eye].patch; }

  /// Moves the upper lid four fifths of the way over the eye and the lower lid the rest, until their edges
  /// meet; the skin up to the crease follows, the eye itself becomes a flat pocket behind the line. Lids that
  /// meet already stay. O(vertices of the eye).
  void shut(int eye, Positions& x) const;

 private:
  struct Eye {
    std::vector<int> patch;  ///< inside the lids
    std::vector<int> loop;   ///< where lids and patch meet
    std::vector<int> lids, moved;
    std::vector<double> weights;  ///< of `lids`: 1 at their edges, falling to 0 towards the brow and cheek
  };
  std::vector<Eye> eyes_;
};

}  // namespace phiz
