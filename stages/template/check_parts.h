#pragma once

#include <string>
#include <vector>

#include "stages/geometry/half_edge.h"
#include "stages/template/check.h"

// Inside of check.cpp, in several sources.
namespace phiz::check_parts {

struct Report {
  std::vector<HeadCheck> checks;
  void add(const std::string& what, const std::string& value, const std::string& bar, bool ok);
  void add_at_least(const std::string& what, double value, double bar, int decimals,
                    const std::string& unit = {});
  void add_at_most(const std::string& what, double value, double bar, int decimals,
                   const std::string& unit = {});
  void add_within(const std::string& what, double value, double low, double high, int decimals,
                  const std::string& unit = {});
};

std::string number(double x, int decimals);

inline double doubled_area(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Around every connected part of the region: its border, then the border of what one more ring of triangles
/// adds, and so on, as long as each is one simple closed loop of edges. The smallest number among the parts,
/// at most 8.
int count_loops_around(const ControlMesh& head, const std::vector<int>& region);

void check_annotations(const ControlMesh& head, Report& report);

/// (u,v): the border of the square, one-to-one, share and stretch of the face.
void check_domain(const ControlMesh& head, const HalfEdgeMesh& mesh, Report& report);

}  // namespace phiz::check_parts
