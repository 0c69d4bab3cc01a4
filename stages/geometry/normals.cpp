#include "stages/geometry/normals.h"

#include <Eigen/Geometry>
#include <cmath>

#include "stages/geometry/angle.h"
#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

constexpr std::size_t kGrain = 8192;

struct WeightedFace {
  Eigen::Vector3d unit_normal;
  Eigen::Vector3d angles;
};

template <class Scalar>
WeightedFace weigh(std::span<const Eigen::Matrix<Scalar, 3, 1>> positions, const Eigen::Vector3i& triangle) {
  const Eigen::Vector3d a = positions[triangle[0]].template cast<double>();
  const Eigen::Vector3d b = positions[triangle[1]].template cast<double>();
  const Eigen::Vector3d c = positions[triangle[2]].template cast<double>();
  const Eigen::Vector3d ab = b - a, bc = c - b, ca = a - c;
  const Eigen::Vector3d normal = ab.cross(-ca);
  const double length = normal.norm();
  if (!(length > 0)) return {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  return {normal / length,
          {angle_of(length, -ab.dot(ca)), angle_of(length, -bc.dot(ab)), angle_of(length, -ca.dot(bc))}};
}

template <class Scalar>
std::vector<Eigen::Matrix<Scalar, 3, 1>> compute(std::span<const Eigen::Matrix<Scalar, 3, 1>> positions,
                                                 std::span<const Eigen::Vector3i> triangles) {
  std::vector<WeightedFace> faces(triangles.size());
  parallel_for(triangles.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) faces[t] = weigh<Scalar>(positions, triangles[t]);
  });
  std::vector<Eigen::Vector3d> sums(positions.size(), Eigen::Vector3d::Zero());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int corner = 0; corner < 3; ++corner)
      sums[triangles[t][corner]] += faces[t].angles[corner] * faces[t].unit_normal;

  std::vector<Eigen::Matrix<Scalar, 3, 1>> normals(positions.size());
  parallel_for(positions.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const double length = sums[v].norm();
      const Eigen::Vector3d normal = length > 0 ? Eigen::Vector3d(sums[v] / length) : Eigen::Vector3d::Zero();
      normals[v] = normal.template cast<Scalar>();
    }
  });
  return normals;
}

}  // namespace

std::vector<Eigen::Vector3d> compute_vertex_normals(std::span<const Eigen::Vector3d> positions,
                                                    std::span<const Eigen::Vector3i> triangles) {
  return compute<double>(positions, triangles);
}

std::vector<Eigen::Vector3f> compute_vertex_normals(std::span<const Eigen::Vector3f> positions,
                                                    std::span<const Eigen::Vector3i> triangles) {
  return compute<float>(positions, triangles);
}

}  // namespace phiz
