#include "stages/geometry/distance_lattice.h"

#include <limits>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"

namespace phiz {
namespace {

constexpr float kFar = 1e12f;

/// One line of the squared distance transform in cell units: lower envelope of parabolas. `stride` apart in
/// f.
struct LineTransform {
  std::vector<float> value, boundary;
  std::vector<int> site;

  void run(float* f, int n, std::size_t stride) {
    value.resize(n);
    boundary.resize(n + 1);
    site.resize(n);
    int k = -1;
    for (int q = 0; q < n; ++q) {
      value[q] = f[q * stride];
      if (value[q] >= kFar) continue;
      float s = -std::numeric_limits<float>::infinity();
      while (k >= 0) {
        const int v = site[k];
        s = ((value[q] + float(q) * q) - (value[v] + float(v) * v)) / (2.0f * (q - v));
        if (s > boundary[k]) break;
        --k;
        s = -std::numeric_limits<float>::infinity();
      }
      site[++k] = q;
      boundary[k] = s;
    }
    if (k < 0) return;
    int j = 0;
    for (int q = 0; q < n; ++q) {
      while (j < k && boundary[j + 1] < q) ++j;
      const float d = float(q - site[j]);
      f[q * stride] = d * d + value[site[j]];
    }
  }
};

}  // namespace

DistanceLattice::DistanceLattice(std::span<const Eigen::Vector3f> points, float margin, int cells_along) {
  CONTRACT(!points.empty() && cells_along > 1);
  Eigen::Array3f low = points[0], high = points[0];
  for (const auto& p : points) {
    low = low.min(p.array());
    high = high.max(p.array());
  }
  low -= margin;
  high += margin;
  cell_ = std::max((high - low).maxCoeff() / cells_along, 1e-20f);
  inverse_cell_ = 1.0f / cell_;
  origin_ = low;
  dims_ = (((high - low) * inverse_cell_).ceil().cast<int>() + 1).max(2);  // a read takes two along each axis
  const int nx = dims_.x(), ny = dims_.y(), nz = dims_.z();
  values_.assign(static_cast<std::size_t>(nx) * ny * nz, kFar);
  for (const auto& p : points) {
    const Eigen::Vector3i c = ((p - origin_) * inverse_cell_).array().round().cast<int>();
    values_[(static_cast<std::size_t>(c.z()) * ny + c.y()) * nx + c.x()] = 0;
  }
  const std::size_t plane = static_cast<std::size_t>(nx) * ny;
  parallel_for(nz, 4, [&](std::size_t begin, std::size_t end) {
    LineTransform line;
    for (std::size_t z = begin; z < end; ++z) {
      for (int y = 0; y < ny; ++y) line.run(&values_[z * plane + static_cast<std::size_t>(y) * nx], nx, 1);
      for (int x = 0; x < nx; ++x) line.run(&values_[z * plane + x], ny, nx);
    }
  });
  parallel_for(ny, 4, [&](std::size_t begin, std::size_t end) {
    LineTransform line;
    for (std::size_t y = begin; y < end; ++y)
      for (int x = 0; x < nx; ++x) line.run(&values_[y * nx + x], nz, plane);
  });
  for (float& v : values_) v = cell_ * std::sqrt(v);
}

DistanceLattice::Sample DistanceLattice::at(const Eigen::Vector3f& p) const {
  const Eigen::Array3f g = (p - origin_).array() * inverse_cell_;
  const Eigen::Array3f inside = g.max(0.0f).min(dims_.array().cast<float>() - 1.001f);
  const Eigen::Array3i i = inside.cast<int>();
  const Eigen::Array3f f = inside - i.cast<float>();
  const std::size_t nx = dims_.x(), plane = nx * dims_.y();
  const float* v = &values_[i.z() * plane + i.y() * nx + i.x()];
  const float c00 = v[0] + f.x() * (v[1] - v[0]);
  const float c10 = v[nx] + f.x() * (v[nx + 1] - v[nx]);
  const float c01 = v[plane] + f.x() * (v[plane + 1] - v[plane]);
  const float c11 = v[plane + nx] + f.x() * (v[plane + nx + 1] - v[plane + nx]);
  const float c0 = c00 + f.y() * (c10 - c00), c1 = c01 + f.y() * (c11 - c01);
  Sample sample;
  sample.distance = c0 + f.z() * (c1 - c0);
  const float dx0 = (v[1] - v[0]) + f.y() * ((v[nx + 1] - v[nx]) - (v[1] - v[0]));
  const float dx1 =
      (v[plane + 1] - v[plane]) + f.y() * ((v[plane + nx + 1] - v[plane + nx]) - (v[plane + 1] - v[plane]));
  const float dy0 = c10 - c00, dy1 = c11 - c01;
  sample.gradient =
      Eigen::Vector3f(dx0 + f.z() * (dx1 - dx0), dy0 + f.z() * (dy1 - dy0), c1 - c0) * inverse_cell_;
  const Eigen::Array3f beyond = (g - inside) * cell_;
  const float outside = beyond.matrix().norm();
  if (outside > 0) {
    sample.distance += outside;
    sample.gradient = (beyond == 0).select(sample.gradient.array(), beyond / outside);
  }
  return sample;
}

}  // namespace phiz
