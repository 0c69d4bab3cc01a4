#include "formats/readers/cloud_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/error.h"

namespace phiz::readers {
namespace {

constexpr std::size_t kEarlyPoints = 4096;
constexpr double kFarInSpreads = 100.0;

std::uint8_t to_byte(float value, float scale) {
  const float scaled = value * scale + 0.5f;
  if (!(scaled > 0.0f)) return 0;
  return scaled < 255.0f ? static_cast<std::uint8_t>(scaled) : 255;
}

struct Spread {
  double middle = 0.0, width = 0.0;  ///< median and distance between the quartiles
};

Spread spread_of(std::vector<double>& values) {
  const auto at = [&](std::size_t rank) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank), values.end());
    return values[rank];
  };
  const std::size_t n = values.size();
  const double low = at(n / 4), high = at(n - 1 - n / 4);
  return {at(n / 2), high - low};
}

}  // namespace

void CloudBuilder::check_count(std::uint64_t points, const ScanLimits& limits, const char* where) {
  const std::uint64_t most = std::min<std::uint64_t>(limits.max_points, std::numeric_limits<int>::max());
  if (points > most)
    throw FormatError("holds " + std::to_string(points) + " points, more than the " + std::to_string(most) +
                          " allowed (" + where + ")",
                      "thin the scan first, or the file is damaged");
}

void CloudBuilder::add_normal(double x, double y, double z) {
  const double length = std::sqrt(x * x + y * y + z * z);
  if (length > 0.0 && std::isfinite(length)) {
    scan.points.normals.emplace_back(static_cast<float>(x / length), static_cast<float>(y / length),
                                     static_cast<float>(z / length));
  } else {
    scan.points.normals.emplace_back(0.0f, 0.0f, 0.0f);
  }
}

void CloudBuilder::add_colour(double r, double g, double b) {
  raw_colours_.push_back({static_cast<float>(r), static_cast<float>(g), static_cast<float>(b)});
}

void CloudBuilder::add_early(double x, double y, double z) {
  early_.emplace_back(x, y, z);
  if (early_.size() == kEarlyPoints) settle();
}

void CloudBuilder::settle() {
  is_settled_ = true;
  std::vector<double> values;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double width = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    values.clear();
    for (const Eigen::Vector3d& p : early_)
      if (p.allFinite()) values.push_back(p[axis]);
    if (values.empty()) break;
    const Spread spread = spread_of(values);
    middle[axis] = spread.middle;
    width = std::max(width, spread.width);
  }
  const bool is_far = middle.cwiseAbs().maxCoeff() > kFarInSpreads * width;
  const bool is_storable = middle.cwiseAbs().maxCoeff() < std::numeric_limits<float>::max();
  if (is_far && is_storable) scan.origin = middle.array().round();
  for (const Eigen::Vector3d& p : early_) add_position(p.x(), p.y(), p.z());
  early_ = {};
}

void CloudBuilder::finish_colours(ColourRange range) {
  if (raw_colours_.size() != scan.points.size() || raw_colours_.empty()) return;
  float largest = 0.0f;
  for (const auto& colour : raw_colours_)
    for (const float value : colour)
      if (std::isfinite(value)) largest = std::max(largest, value);
  float scale = 1.0f;
  if (range != ColourRange::bytes && largest > 255.5f) scale = 1.0f / 257.0f;
  if (range == ColourRange::numbers && largest <= 1.5f) scale = 255.0f;
  scan.points.colours.reserve(raw_colours_.size());
  for (const auto& c : raw_colours_)
    scan.points.colours.push_back({to_byte(c[0], scale), to_byte(c[1], scale), to_byte(c[2], scale)});
}

void CloudBuilder::finish_confidences() {
  float largest = 1.0f;
  for (const float value : scan.points.confidences)
    if (std::isfinite(value)) largest = std::max(largest, value);
  for (float& value : scan.points.confidences) value = value > 0.0f ? std::min(value / largest, 1.0f) : 0.0f;
}

ScanFile CloudBuilder::finish(std::string format, ColourRange colour_range) {
  if (!is_settled_) settle();
  PointCloud& points = scan.points;
  if (points.size() == 0) throw FormatError("holds no points", "was the right object exported?");
  finish_colours(colour_range);
  finish_confidences();
  if (points.normals.size() != points.size()) points.normals = {};
  if (points.colours.size() != points.size()) points.colours = {};
  if (points.confidences.size() != points.size()) points.confidences = {};
  scan.format = std::move(format);
  return std::move(scan);
}

}  // namespace phiz::readers
