#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace phiz {

/// The new vertices of one level of 1:4 splits and what lies beside them. Level k+1 keeps the vertices of
/// level k and appends one for each of its edges, numbered by the first half-edge that runs along them:
/// half-edge 3 t + i runs from corner i to corner i+1 of triangle t. Triangle t becomes 4t .. 4t+3: its
/// corners in order, then the middle one. Level 0: all control vertices are new.
class LevelTopology {
 public:
  /// Level 0. Throws FormatError: corners out of range, an edge of more than two triangles or of two that
  /// disagree in orientation, a triangle with one vertex twice. O(F log F).
  LevelTopology(std::span<const Eigen::Vector3i> triangles, std::size_t vertex_count);
  /// The next finer level. O(F).
  LevelTopology next() const;
  std::size_t next_vertex_count() const { return vertex_count_ + edge_count_; }  ///< without making it

  bool is_control() const { return first_new_ == 0; }
  std::size_t vertex_count() const { return vertex_count_; }
  std::size_t first_new() const { return first_new_; }
  std::size_t new_count() const { return vertex_count_ - first_new_; }
  std::size_t triangle_count() const { return corners_.size() / 3; }

  /// New vertices beside new vertex i that come before it, counted from first_new(). At most 4 above level 0.
  std::span<const int> earlier(std::size_t i) const {
    return {earlier_.data() + offsets_[i], earlier_.data() + offsets_[i + 1]};
  }
  /// The two vertices of the coarser level between which new vertex i lies. Not for level 0.
  const std::array<int, 2>& parents(std::size_t i) const { return parents_[i]; }

 private:
  LevelTopology() = default;
  void number_edges();

  std::size_t vertex_count_ = 0, first_new_ = 0, edge_count_ = 0;
  std::vector<int> corners_;  ///< of the triangles: corners_[h] is where half-edge h begins
  std::vector<int> twins_;    ///< -1 on the border
  std::vector<int> edges_;    ///< of half-edges
  std::vector<int> offsets_, earlier_;
  std::vector<std::array<int, 2>> parents_;
};

}  // namespace phiz
