#include "stages/ingest/field.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "stages/geometry/point_grid.h"

namespace phiz {
namespace {

constexpr int kBand = 3;

struct CellPlane {
  Eigen::Vector3f position = Eigen::Vector3f::Zero(), normal = Eigen::Vector3f::Zero();
  float confidence = 0;
  bool used = false;
};

std::vector<CellPlane> cell_planes(const PointCloud& cloud, const PointGrid& grid) {
  std::vector<CellPlane> planes(grid.cell_count());
  parallel_for(planes.size(), 16384, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      const int count = grid.cell_end(c) - grid.cell_begin(c);
      if (count == 0) continue;
      CellPlane& plane = planes[c];
      for (int slot = grid.cell_begin(c); slot < grid.cell_end(c); ++slot) {
        const int i = grid.order()[slot];
        plane.position += cloud.positions[i];
        plane.normal += cloud.normals[i];
        plane.confidence += cloud.confidences[i];
      }
      plane.position /= float(count);
      plane.confidence /= float(count);
      const float length = plane.normal.norm();
      plane.used = length > 0.3f * count;  // two sheets in one cell cancel and are left to their neighbours
      if (plane.used) plane.normal /= length;
    }
  });
  return planes;
}

/// Which lattice places, kBand cells beyond the grid included, have a used cell within kBand cells along each
/// axis. Three passes of one axis each.
class Band {
 public:
  Band(const PointGrid& grid, const std::vector<CellPlane>& planes)
      : dims_(grid.dimensions() + Eigen::Vector3i::Constant(2 * kBand)) {
    near_.assign(static_cast<std::size_t>(dims_.x()) * dims_.y() * dims_.z(), 0);
    for (int z = 0; z < grid.dimensions().z(); ++z)
      for (int y = 0; y < grid.dimensions().y(); ++y)
        for (int x = 0; x < grid.dimensions().x(); ++x)
          near_[index({x, y, z})] = planes[grid.cell_index({x, y, z})].used;
    const std::size_t row = dims_.x(), slice = row * dims_.y();
    spread(1, dims_.x(), {row, dims_.y()}, {slice, dims_.z()});
    spread(row, dims_.y(), {1, dims_.x()}, {slice, dims_.z()});
    spread(slice, dims_.z(), {1, dims_.x()}, {row, dims_.y()});
  }
  bool contains(const Eigen::Vector3i& c) const { return near_[index(c)]; }

 private:
  using Axis = std::pair<std::size_t, int>;  ///< stride, count
  std::size_t index(const Eigen::Vector3i& c) const {
    return ((static_cast<std::size_t>(c.z()) + kBand) * dims_.y() + c.y() + kBand) * dims_.x() + c.x() +
           kBand;
  }
  void spread(std::size_t stride, int count, Axis a, Axis b) {
    std::vector<char> line(count);
    for (int i = 0; i < a.second; ++i)
      for (int j = 0; j < b.second; ++j) {
        char* first = &near_[i * a.first + j * b.first];
        int last_used = -kBand - 1;
        for (int k = 0; k < count; ++k) {
          if (first[k * stride]) last_used = k;
          line[k] = k - last_used <= kBand;
        }
        last_used = count + kBand;
        for (int k = count - 1; k >= 0; --k) {
          if (first[k * stride]) last_used = k;
          line[k] |= last_used - k <= kBand;
        }
        for (int k = 0; k < count; ++k) first[k * stride] = line[k];
      }
  }
  Eigen::Vector3i dims_;
  std::vector<char> near_;
};

/// Weighted mean of the signed plane distances of the cells around `c`; false where none is in reach.
bool sample_field(const PointGrid& grid, const std::vector<CellPlane>& planes, const Eigen::Vector3i& c,
                  float voxel, float& distance, float& confidence) {
  const Eigen::Vector3f p = grid.origin() + voxel * c.cast<float>();
  float weight_sum = 0, value_sum = 0, confidence_sum = 0;
  for (int dz = -kBand; dz <= kBand; ++dz)
    for (int dy = -kBand; dy <= kBand; ++dy)
      for (int dx = -kBand; dx <= kBand; ++dx) {
        const Eigen::Vector3i n = c + Eigen::Vector3i(dx, dy, dz);
        if (!grid.contains(n)) continue;
        const CellPlane& plane = planes[grid.cell_index(n)];
        if (!plane.used) continue;
        const Eigen::Vector3f d = p - plane.position;
        const float squared = d.squaredNorm() / (voxel * voxel);
        if (squared > kBand * kBand) continue;
        const float w = 1.0f / (0.05f + squared * squared * squared);
        weight_sum += w;
        value_sum += w * plane.normal.dot(d);
        confidence_sum += w * plane.confidence / (1 + squared);
      }
  if (weight_sum <= 0) return false;
  distance = value_sum / weight_sum;
  confidence = confidence_sum / weight_sum;
  return true;
}

}  // namespace

DistanceField compute_distance_field(const PointCloud& cloud, double voxel_mm) {
  CONTRACT(cloud.has_normals() && cloud.has_confidences() && voxel_mm > 0);
  const PointGrid grid(cloud.positions, static_cast<float>(voxel_mm));
  DistanceField field;
  field.voxel_mm = grid.cell();
  field.truncation_mm = kBand * field.voxel_mm;
  field.origin_mm = grid.origin().cast<double>();
  const auto planes = cell_planes(cloud, grid);
  const Eigen::Vector3i dims = grid.dimensions();
  const float voxel = grid.cell(), limit = static_cast<float>(field.truncation_mm);

  const Band band(grid, planes);
  std::vector<DistanceField> slices(dims.x() +
                                    2 * kBand);  // x-major: the lexicographic order of the coordinates
  parallel_for(slices.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) {
      const int x = static_cast<int>(s) - kBand;
      for (int y = -kBand; y < dims.y() + kBand; ++y)
        for (int z = -kBand; z < dims.z() + kBand; ++z) {
          if (!band.contains({x, y, z})) continue;
          float distance, confidence;
          if (!sample_field(grid, planes, {x, y, z}, voxel, distance, confidence)) continue;
          slices[s].coordinates.push_back({x, y, z});
          slices[s].distances_mm.push_back(std::clamp(distance, -limit, limit));
          slices[s].confidences.push_back(confidence);
        }
    }
  });
  for (const auto& slice : slices) {
    field.coordinates.insert(field.coordinates.end(), slice.coordinates.begin(), slice.coordinates.end());
    field.distances_mm.insert(field.distances_mm.end(), slice.distances_mm.begin(), slice.distances_mm.end());
    field.confidences.insert(field.confidences.end(), slice.confidences.begin(), slice.confidences.end());
  }
  return field;
}

}  // namespace phiz
