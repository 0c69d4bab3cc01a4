#include <algorithm>
#include <array>
#include <cmath>

#include "stages/deform/deform.h"
#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

/// Four weights of the nodes at -1, 0, 1, 2 and their slopes at t in [0,1].
struct Weights {
  std::array<double, 4> at{}, slope{};
};

Weights weights_of(FieldInterpolation interpolation, double t) {
  if (interpolation == FieldInterpolation::kBilinear) return {{0, 1 - t, t, 0}, {0, -1, 1, 0}};
  const double t2 = t * t, t3 = t2 * t;  // Catmull-Rom
  return {
      {0.5 * (-t + 2 * t2 - t3), 0.5 * (2 - 5 * t2 + 3 * t3), 0.5 * (t + 4 * t2 - 3 * t3), 0.5 * (-t2 + t3)},
      {0.5 * (-1 + 4 * t - 3 * t2), 0.5 * (-10 * t + 9 * t2), 0.5 * (1 + 8 * t - 9 * t2),
       0.5 * (-2 * t + 3 * t2)}};
}

/// The cell that holds a coordinate and the place in it; clamped to the grid.
struct Cell {
  int index = 0;
  double t = 0;
  bool is_inside = true;  ///< slopes are zero beyond the border
};

Cell cell_of(double coordinate, int nodes) {
  const double at = coordinate * (nodes - 1);
  if (!(at > 0)) return {0, 0, at == 0};
  if (at >= nodes - 1) return {nodes - 2, 1, at == nodes - 1};
  const int index = std::min(static_cast<int>(at), nodes - 2);
  return {index, at - index, true};
}

Eigen::Vector3d node(const FieldImage& image, int x, int y) {
  x -= image.x, y -= image.y;
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return value;
  const std::size_t at = (static_cast<std::size_t>(y) * image.width + x) * image.channels;
  for (int c = 0; c < image.channels; ++c) value[c] = image.values[at + c];
  return value;
}

/// Interleaved bits of a place in the (u,v) square: neighbours in this order are neighbours on the surface.
std::uint32_t morton_of(const Eigen::Vector2d& uv) {
  const auto spread = [](double x) {
    auto bits = static_cast<std::uint32_t>(std::clamp(x, 0.0, 1.0) * 65535);
    bits = (bits | (bits << 8)) & 0x00ff00ffu;
    bits = (bits | (bits << 4)) & 0x0f0f0f0fu;
    bits = (bits | (bits << 2)) & 0x33333333u;
    return (bits | (bits << 1)) & 0x55555555u;
  };
  return spread(uv.x()) | (spread(uv.y()) << 1);
}

std::vector<int> order_of(std::span<const Eigen::Vector2d> uv) {
  std::vector<std::pair<std::uint32_t, int>> keys(uv.size());
  for (std::size_t i = 0; i < uv.size(); ++i) keys[i] = {morton_of(uv[i]), static_cast<int>(i)};
  std::sort(keys.begin(), keys.end());
  std::vector<int> order;
  for (const auto& [key, point] : keys) order.push_back(point);
  return order;
}

bool is_zero(const FieldSample& sample) {
  return sample.value.isZero(0);
}

}  // namespace

FieldSample sample_field(const DeformationField& field, int grid_width, int grid_height,
                         const Eigen::Vector2d& uv) {
  const FieldImage& image = field.image;
  FieldSample sample;
  if (image.empty()) return sample;
  const Cell column = cell_of(uv.x(), grid_width), row = cell_of(1 - uv.y(), grid_height);
  constexpr int kReach = 2;
  if (column.index < image.x - kReach || column.index >= image.x + image.width + kReach ||
      row.index < image.y - kReach || row.index >= image.y + image.height + kReach)
    return sample;
  const Weights across = weights_of(field.interpolation, column.t),
                down = weights_of(field.interpolation, row.t);
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) {
      const double weight = across.at[i] * down.at[j];
      const double slope_u = across.slope[i] * down.at[j], slope_v = across.at[i] * down.slope[j];
      if (weight == 0 && slope_u == 0 && slope_v == 0) continue;
      const Eigen::Vector3d value = node(image, std::clamp(column.index + i - 1, 0, grid_width - 1),
                                         std::clamp(row.index + j - 1, 0, grid_height - 1));
      sample.value += weight * value;
      if (column.is_inside) sample.du += slope_u * (grid_width - 1) * value;
      if (row.is_inside) sample.dv -= slope_v * (grid_height - 1) * value;
    }
  }
  return sample;
}

SampledFields sample_fields(const Deformation& deformation, std::span<const Eigen::Vector2d> uv,
                            const AnalyticFields& analytic) {
  SampledFields sampled;
  sampled.point_count = uv.size();
  sampled.order = order_of(uv);
  sampled.fields.resize(deformation.fields.size());
  parallel_for(sampled.fields.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      const DeformationField& field = deformation.fields[f];
      const auto function = analytic.find(field.name);
      const bool has_image = !field.image.empty();
      if (function == analytic.end() && !has_image) continue;
      for (std::size_t i = 0; i < uv.size(); ++i) {
        const FieldSample sample = function != analytic.end()
                                       ? function->second(uv[i])
                                       : sample_field(field, deformation.width, deformation.height, uv[i]);
        if (is_zero(sample)) continue;
        sampled.fields[f].points.push_back(static_cast<int>(i));
        sampled.fields[f].values.push_back(sample.value.cast<float>());
      }
    }
  });
  sampled.offsets.assign(uv.size() + 1, 0);
  for (const SampledFields::Field& field : sampled.fields) {
    for (const int point : field.points) ++sampled.offsets[point + 1];
  }
  for (std::size_t i = 0; i < uv.size(); ++i) sampled.offsets[i + 1] += sampled.offsets[i];
  std::vector<int> next(sampled.offsets.begin(), sampled.offsets.end() - 1);
  sampled.point_fields.resize(sampled.offsets.back());
  sampled.point_entries.resize(sampled.offsets.back());
  for (std::size_t f = 0; f < sampled.fields.size(); ++f) {
    for (std::size_t k = 0; k < sampled.fields[f].points.size(); ++k) {
      const int at = next[sampled.fields[f].points[k]]++;
      sampled.point_fields[at] = static_cast<int>(f);
      sampled.point_entries[at] = static_cast<int>(k);
    }
  }
  return sampled;
}

std::vector<float> parameters_of_controls(const Deformation& deformation, std::span<const float> controls) {
  std::map<std::string, std::size_t> index;
  for (const DeformationParameter& parameter : deformation.parameters)
    index.emplace(parameter.name, index.size());
  std::vector<double> sums(deformation.parameters.size(), 0.0);
  for (std::size_t c = 0; c < deformation.controls.size() && c < controls.size(); ++c) {
    for (const auto& [name, weight] : deformation.controls[c].terms)
      sums[index.at(name)] += weight * controls[c];
  }
  std::vector<float> parameters;
  for (std::size_t k = 0; k < sums.size(); ++k) {
    const DeformationParameter& parameter = deformation.parameters[k];
    parameters.push_back(static_cast<float>(std::clamp(sums[k], parameter.minimum, parameter.maximum)));
  }
  return parameters;
}

}  // namespace phiz
