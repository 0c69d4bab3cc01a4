#pragma once

#include <string>
#include <vector>

#include "stages/geometry/half_edge.h"
#include "stages/template/check.h"

// Inside of check.cpp, in several sources.
namespace phiz::check_parts {

struct Report {
  std::vector<HeadCheck> checks;
  std::string picture;  ///< of the checks that come next
  void add(const std::string& what, const std::string& value, const std::string& bar, bool ok);
  void add_at_least(const std::string& what, double value, double bar, int decimals,
                    const std::string& unit = {});
  void add_at_most(const std::string& what, double value, double bar, int decimals,
                   const std::string& unit = {});
  void add_within(const std::string& what, double value, double low, double high, int decimals,
                  const std::string& unit = {});
  void add_none(const std::string& what, std::size_t count);         ///< the bar is 0
  void add_note(const std::string& what, const std::string& value);  ///< without a bar
};

std::string number(double x, int decimals);

inline double doubled_area(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Per triangle, whether all its corners are in the region.
std::vector<bool> find_triangles_inside(const ControlMesh& head, const std::vector<int>& region);

/// Around every connected part of the region: its border, then the border of what one more ring of triangles
/// adds, and so on, as long as each is one simple closed loop of edges.
struct Loops {
  static constexpr int kMost = 8;
  int fewest = 0;          ///< the smallest number among the parts, at most kMost
  std::vector<int> rings;  ///< as in HeadMeasures
};
Loops find_loops_around(const ControlMesh& head, const std::vector<int>& region);

/// Largest and smallest length on the surface of a unit step in (u,v).
Eigen::Vector2d compute_stretches(const ControlMesh& head, const Eigen::Vector3i& t);

/// Whether the head says it has a human face: some of the usual 68 landmarks.
bool has_human_face(const ControlMesh& head);

void check_annotations(const ControlMesh& head, Report& report);

/// (u,v): the border of the square, one-to-one, share and stretch of the face. Whether it is one-to-one.
bool check_domain(const ControlMesh& head, const HalfEdgeMesh& mesh, Report& report);

/// The order of vertices and triangles, against the codecs.
void check_order(const ControlMesh& head, Report& report);

}  // namespace phiz::check_parts
