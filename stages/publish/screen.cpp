#include "stages/publish/screen.h"

#include <algorithm>
#include <cmath>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

struct NamedCamera {
  std::string_view name;
  Camera camera;
};

constexpr NamedCamera kCameras[] = {
    {"front", {0, 0}},  {"left", {90, 0}},         {"right", {-90, 0}},
    {"side", {90, 0}},  {"threequarter", {40, 8}}, {"threequarter-right", {-40, 8}},
    {"back", {180, 0}}, {"top", {0, 90}},          {"under", {0, -50}}};

constexpr float kMargin = 1.03f, kRobustMargin = 1.10f;

struct SineCosine {
  double sine, cosine;
};

// By Taylor series on [-45, 45] degrees and symmetry: the same bits with every mathematical library.
SineCosine compute_sine_cosine(double degrees) {
  degrees = std::fmod(degrees, 360.0);
  const double quarters = std::nearbyint(degrees / 90.0);
  const double x = (degrees - 90.0 * quarters) * (3.14159265358979323846 / 180.0);
  const double xx = x * x;
  double sine = 0, cosine = 0, term = 1;
  for (int k = 0; k < 20; k += 2) {
    cosine += term;
    sine += term / (k + 1);
    term *= -xx / ((k + 1) * (k + 2));
  }
  sine *= x;
  switch ((static_cast<long long>(quarters) % 4 + 4) % 4) {
    case 0:
      return {sine, cosine};
    case 1:
      return {cosine, -sine};
    case 2:
      return {-sine, -cosine};
    default:
      return {-cosine, sine};
  }
}

Eigen::Matrix3f make_rotation(const Camera& camera) {
  const auto [sa, ca] = compute_sine_cosine(camera.azimuth_deg);
  const auto [se, ce] = compute_sine_cosine(camera.elevation_deg);
  const Eigen::Vector3d viewer(sa * ce, se, ca * ce), right(ca, 0, -sa);
  Eigen::Matrix3d rows;
  rows << right.transpose(), viewer.cross(right).transpose(), viewer.transpose();
  return rows.cast<float>();
}

Eigen::AlignedBox3f find_box(std::span<const Eigen::Vector3f> positions) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : positions)
    if (p.allFinite()) box.extend(p);
  return box;
}

// How far the positions within the box lie from its centre, to the right or left and up or down in the view.
Eigen::Array2f find_reach(const Screen& screen, const Eigen::AlignedBox3f& box,
                          std::span<const Eigen::Vector3f> positions) {
  Eigen::Array2f reach = Eigen::Array2f::Zero();
  for (const Eigen::Vector3f& p : positions) {
    if (!box.contains(p)) continue;
    const Eigen::Vector3f view = screen.rotation * (p - screen.centre_mm);
    reach = reach.max(view.head<2>().array().abs());
  }
  return reach;
}

}  // namespace

Eigen::AlignedBox3f find_robust_box(std::span<const Eigen::Vector3f> positions) {
  Eigen::AlignedBox3f box;
  std::vector<float> values;
  for (int axis = 0; axis < 3; ++axis) {
    values.clear();
    for (const Eigen::Vector3f& p : positions)
      if (p.allFinite()) values.push_back(p[axis]);
    if (values.empty()) return {};
    const auto cut = static_cast<std::ptrdiff_t>(values.size() / 200);
    std::nth_element(values.begin(), values.begin() + cut, values.end());
    box.min()[axis] = values[static_cast<std::size_t>(cut)];
    std::nth_element(values.begin(), values.end() - 1 - cut, values.end());
    box.max()[axis] = *(values.end() - 1 - cut);
  }
  return box;
}

std::optional<Camera> find_camera(std::string_view name) {
  for (const NamedCamera& entry : kCameras)
    if (entry.name == name) return entry.camera;
  return std::nullopt;
}

Eigen::Vector3f Screen::project(const Eigen::Vector3f& position_mm) const {
  const Eigen::Vector3f view = rotation * (position_mm - centre_mm) * samples_per_mm;
  return {static_cast<float>(width) * 0.5f + view.x(), static_cast<float>(height) * 0.5f - view.y(),
          view.z()};
}

Screen make_screen(const ViewOptions& options, std::span<const Eigen::Vector3f> positions,
                   const ScreenStyle& style) {
  if (std::min(options.width, options.height) < 8 || std::max(options.width, options.height) > 8192)
    throw InvalidInput("picture of " + std::to_string(options.width) + " x " +
                       std::to_string(options.height) + " pixels: sizes must be 8 to 8192");
  if (!std::isfinite(options.camera.azimuth_deg) || !std::isfinite(options.camera.elevation_deg))
    throw InvalidInput("camera angle that is not a finite number");
  Eigen::AlignedBox3f box = options.frame_mm ? *options.frame_mm
                            : style.robust   ? find_robust_box(positions)
                                             : find_box(positions);
  if (!options.frame_mm && box.isEmpty())  // nothing to see: any frame will do
    box = Eigen::AlignedBox3f(Eigen::Vector3f::Constant(-1), Eigen::Vector3f::Constant(1));
  if (box.isEmpty() || !box.sizes().allFinite()) throw InvalidInput("empty frame for a picture");
  Screen screen;
  screen.rotation = make_rotation(options.camera);
  screen.centre_mm = box.center();
  screen.samples = style.samples;
  screen.width = options.width * style.samples;
  screen.height = options.height * style.samples;
  const Eigen::Vector3f half = box.sizes() * 0.5f;
  const auto [se, ce] = compute_sine_cosine(options.camera.elevation_deg);
  float across = std::max(half.x(), half.z());
  float upright = static_cast<float>(std::abs(ce)) * half.y() + static_cast<float>(std::abs(se)) * across;
  if (!options.frame_mm) {  // the corners of a box may reach further than its sides
    const Eigen::Array2f reach = find_reach(screen, box, positions);
    across = std::max(across, reach.x());
    upright = std::max(upright, reach.y());
  }
  const float margin = options.frame_mm ? 1.0f : style.robust ? kRobustMargin : kMargin;
  const float smallest = 1e-6f;
  screen.samples_per_mm =
      0.5f * std::min(static_cast<float>(screen.width) / std::max(across * margin, smallest),
                      static_cast<float>(screen.height) / std::max(upright * margin, smallest));
  return screen;
}

}  // namespace phiz
