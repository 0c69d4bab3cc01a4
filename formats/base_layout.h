#pragma once

#include <Eigen/Core>
#include <iosfwd>
#include <string>
#include <utility>
#include <vector>

namespace phiz {

/// A coarse mesh over the (u,v) square as a person draws it: points, and edges that must be there.
struct BaseLayout {
  std::vector<std::string> names;          ///< of the points, each once
  std::vector<Eigen::Vector2d> uv;         ///< in [0,1]^2; the square's corners among them
  std::vector<std::pair<int, int>> edges;  ///< by index
};

/// JSON; README.md documents the keys. Throws FormatError with the key: unknown or missing keys, names twice
/// or unknown, what is no number in [0,1], more than 100,000 points.
BaseLayout read_base_layout(std::istream& in);

}  // namespace phiz
