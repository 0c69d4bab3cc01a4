#include "stages/ingest/soup.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "stages/geometry/error.h"

namespace phiz {

PointCloud sample_soup(const ScanFile& scan, int samples) {
  CONTRACT(samples > 0);
  const auto& p = scan.points.positions;
  std::vector<double> cumulated;
  cumulated.reserve(scan.triangles.size());
  double total = 0;
  for (const auto& t : scan.triangles) {
    const Eigen::Vector3d a = p[t[0]].cast<double>(), b = p[t[1]].cast<double>(), c = p[t[2]].cast<double>();
    const double area = 0.5 * (b - a).cross(c - a).norm();
    total += std::isfinite(area) ? area : 0.0;
    cumulated.push_back(total);
  }
  if (!(total > 0) || !std::isfinite(total)) throw InvalidInput("the scan's triangles have no area");

  PointCloud cloud;
  cloud.positions.reserve(samples);
  const bool coloured = scan.points.has_colours();
  for (int i = 0; i < samples; ++i) {
    const double target = (i + 0.5) / samples * total;
    const std::size_t t_idx = std::min<std::size_t>(
        std::upper_bound(cumulated.begin(), cumulated.end(), target) - cumulated.begin(),
        scan.triangles.size() - 1);
    // R2 sequence (Roberts 2018): additive recurrence with the plastic number.
    double u = std::fmod(0.5 + 0.7548776662466927 * (i + 1), 1.0),
           v = std::fmod(0.5 + 0.5698402909980532 * (i + 1), 1.0);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const auto& t = scan.triangles[t_idx];
    const float w0 = static_cast<float>(1 - u - v), w1 = static_cast<float>(u), w2 = static_cast<float>(v);
    cloud.positions.push_back(w0 * p[t[0]] + w1 * p[t[1]] + w2 * p[t[2]]);
    if (!coloured) continue;
    std::array<std::uint8_t, 3> colour;
    for (int k = 0; k < 3; ++k)
      colour[k] = static_cast<std::uint8_t>(std::lround(w0 * scan.points.colours[t[0]][k] +
                                                        w1 * scan.points.colours[t[1]][k] +
                                                        w2 * scan.points.colours[t[2]][k]));
    cloud.colours.push_back(colour);
  }
  return cloud;
}

}  // namespace phiz
