#pragma once

#include <span>
#include <vector>

#include "stages/animate/face_layout.h"
#include "stages/animate/point4.h"

namespace phiz {

/// Lips and lids: two polylines between common corners, one above the other. Heights are measured across the
/// line through the corners (+y turned upright against it), each vertex against the other side's polyline. A
/// rim may not get lower than it was at rest, or than 0 where there it was open.
class SkinRims {
 public:
  SkinRims(const FaceLayout& layout, const std::vector<Point4>& rest);

  /// Adds stiffness * depth to the forces (they are gradients: pointing into the crossing) where sides cross.
  void add_gradient(const std::vector<Point4>& positions, float stiffness,
                    std::vector<Point4>& gradient) const;
  /// Moves vertices apart until nothing crosses: both sides alike, some passes in fixed order.
  void part(std::vector<Point4>& positions) const;
  /// How far sides are through each other at most, mm; 0: nowhere.
  double deepest(const std::vector<Point4>& positions) const;
  const std::vector<int>& vertices() const { return vertices_; }  ///< of all rims, ascending, each once

 private:
  struct Contact {
    int vertex = 0, from = 0, to = 0;  ///< the other side's edge
    float share = 0;                   ///< of `to`
    float depth = 0;                   ///< > 0: crossed by so much
    float nx = 0, ny = 0, nz = 0;      ///< the way out for `vertex`
  };
  struct Rim {
    std::vector<int> upper, lower;
    std::vector<float> upper_least, lower_least;  ///< allowed height of each inner vertex, <= 0
  };
  template <class Act>
  void for_contacts(const Rim& rim, const std::vector<Point4>& positions, const Act& act) const;

  std::vector<Rim> rims_;
  std::vector<int> vertices_;
};

}  // namespace phiz
