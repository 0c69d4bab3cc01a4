#pragma once

#include <iosfwd>
#include <map>
#include <string>
#include <vector>

namespace phiz {

/// Principal components of heads over the (u,v) square: mean and components as geometry images of one grid
/// (nodes as in GeometryImage), three numbers a node in row order, heads brought onto the generic head by a
/// rigid motion.
struct ShapeSpace {
  std::string template_digest;  ///< SHA-256 of the generic head; may be empty
  int width = 0, height = 0;    ///< 2 .. 4096
  std::vector<float> weights;   ///< one a node, mm^2 of the generic head, above 0: of the inner product
  std::vector<float> mean;      ///< mm, 3 a node
  std::vector<std::vector<float>> components;  ///< 3 a node, orthonormal in the weights; at most 1000
  std::vector<double> variances;               ///< along each, falling; mm^4
  double total_variance = 0;                   ///< of all subjects, kept or cut off
  std::map<std::string, std::vector<double>> subjects;  ///< name -> a coefficient a component
};

/// A JSON (schema, grid, variances, coefficients) and an EXR with layers `mean.X .Y .Z`, `weight.V`, `c000.X
/// .Y .Z`, `c001` ... in FLOAT. Same space, same bytes. Throw FormatError: sizes, layers, numbers, an EXR of
/// another grid or template.
void write_shape_space(const ShapeSpace& space, std::ostream& json, std::ostream& exr);
ShapeSpace read_shape_space(std::istream& json, std::istream& exr);

}  // namespace phiz
