#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "stages/geometry/error.h"
#include "stages/geometry/parallel.h"
#include "stages/geometry/surface_index.h"
#include "stages/synth/random_stream.h"
#include "stages/synth/synth.h"
#include "stages/synth/value_noise.h"

namespace phiz {
namespace {

using Eigen::Vector3d;

constexpr double kRadians = std::numbers::pi / 180;
constexpr double kOffSurfaceMm = 1e-3;  ///< a shadow ray starts this far above the surface
constexpr double kNoiseLimit = 3.3, kPilotSpacingMm = 7, kSpare = 1.12, kHairPatchMm = 14;

struct Sample {
  Vector3d position;
  std::array<std::uint8_t, 3> colour;
};

/// Camera, projector and the plane through the middle of the target that rays are spread over.
struct Rig {
  Vector3d camera, projector, middle, right, up;
};

Rig make_rig(const ScanView& view, const ScanOptions& options, const Vector3d& middle) {
  const double azimuth = view.azimuth_deg * kRadians, elevation = view.elevation_deg * kRadians;
  const Vector3d out(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                     std::cos(azimuth) * std::cos(elevation));
  Rig rig;
  rig.middle = middle;
  rig.right = Vector3d(std::cos(azimuth), 0, -std::sin(azimuth));
  rig.up = out.cross(rig.right);
  rig.camera = middle + options.distance_mm * out;
  rig.projector = rig.camera + options.baseline_mm * rig.right;
  return rig;
}

class Scanner {
 public:
  Scanner(const ScanTarget& target, const ScanOptions& options, std::uint64_t seed)
      : target_(target),
        options_(options),
        seed_(seed),
        index_(target.mesh.positions, target.mesh.triangles),
        hair_patches_(seed ^ 0x68616972) {
    for (const Eigen::Vector3f& p : target.mesh.positions) {
      const Vector3d q = p.cast<double>();
      if (!options.cut || options.cut->normal.dot(q) >= options.cut->offset_mm) box_.extend(q);
    }
    if (box_.isEmpty()) throw InvalidInput("the scanner's cut leaves nothing of the target");
  }

  /// All samples of all views, in order of view, row and column.
  std::vector<Sample> scan(double spacing_mm, std::uint64_t pass) const {
    std::vector<Sample> samples;
    for (std::size_t view = 0; view < options_.views.size(); ++view) {
      std::vector<Sample> seen = scan_view(static_cast<int>(view), spacing_mm, pass);
      samples.insert(samples.end(), seen.begin(), seen.end());
    }
    return samples;
  }

 private:
  std::vector<Sample> scan_view(int view, double spacing_mm, std::uint64_t pass) const {
    const Rig rig = make_rig(options_.views[view], options_, box_.center());
    const double half_mm = 0.55 * box_.diagonal().norm();
    const int rows = static_cast<int>(std::ceil(2 * half_mm / spacing_mm));
    std::vector<std::vector<Sample>> found(rows);
    parallel_for(rows, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t row = begin; row < end; ++row) {
        for (int column = 0; column < rows; ++column) {
          RandomStream random({seed_, pass, std::uint64_t(view), row, std::uint64_t(column)});
          const double x = (column + random.uniform()) * spacing_mm - half_mm;
          const double y = (static_cast<double>(row) + random.uniform()) * spacing_mm - half_mm;
          if (auto sample = cast(rig, rig.middle + x * rig.right + y * rig.up, random)) {
            found[row].push_back(*sample);
          }
        }
      }
    });
    std::vector<Sample> samples;
    for (const auto& row : found) samples.insert(samples.end(), row.begin(), row.end());
    shift_view(view, pass, samples);
    return samples;
  }

  std::optional<Sample> cast(const Rig& rig, const Vector3d& through, RandomStream& random) const {
    const Vector3d ray = (through - rig.camera).normalized();
    const auto hit = index_.find_first_hit(rig.camera, ray, 0, 4 * options_.distance_mm);
    if (!hit) return std::nullopt;
    const Eigen::Vector3i& triangle = target_.mesh.triangles[hit->triangle_idx];
    Vector3d corners[3];
    for (int i = 0; i < 3; ++i) corners[i] = target_.mesh.positions[triangle[i]].cast<double>();
    const Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    const Vector3d place =
        corners[0] * hit->weights[0] + corners[1] * hit->weights[1] + corners[2] * hit->weights[2];
    const double cosine = -normal.dot(ray);
    if (!(cosine > std::cos(options_.camera_limit_deg * kRadians))) return std::nullopt;
    if (!sees_projector(rig, place, normal)) return std::nullopt;
    int strongest = 0;
    hit->weights.maxCoeff(&strongest);
    const auto noise = draw_noise(target_.materials[triangle[strongest]], place, cosine, random);
    if (!noise) return std::nullopt;
    Sample sample{place + *noise * ray, {}};
    for (int i = 0; i < 3; ++i) {
      double value = 0;
      for (int k = 0; k < 3; ++k) value += hit->weights[k] * target_.mesh.colours[triangle[k]][i];
      sample.colour[i] = static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0));
    }
    return sample;
  }

  bool sees_projector(const Rig& rig, const Vector3d& place, const Vector3d& normal) const {
    const Vector3d way = rig.projector - place;
    if (!(normal.dot(way) > std::cos(options_.projector_limit_deg * kRadians) * way.norm())) return false;
    return !index_.find_first_hit(place + kOffSurfaceMm * normal, way, 0, 1);
  }

  /// Error along the ray; nothing where the sample is lost.
  std::optional<double> draw_noise(ScanMaterial material, const Vector3d& place, double cosine,
                                   RandomStream& random) const {
    double sigma = options_.noise_mm * std::min(kNoiseLimit, 1 / cosine), loss = 0;
    if (material == ScanMaterial::kHair) {
      sigma = options_.hair_noise_mm;
      const double patch = std::clamp(1.5 * hair_patches_.at(place / kHairPatchMm) - 0.25, 0.0, 1.0);
      loss = options_.hair_loss_low + patch * (options_.hair_loss_high - options_.hair_loss_low);
    } else if (material == ScanMaterial::kEye) {
      sigma = options_.eye_noise_mm;
      loss = options_.eye_loss;
    }
    if (random.uniform() < loss) return std::nullopt;
    return sigma * random.normal();
  }

  /// The view's own registration error, and the cut.
  void shift_view(int view, std::uint64_t pass, std::vector<Sample>& samples) const {
    RandomStream random({seed_, pass, std::uint64_t(view), 0x76696577});
    Vector3d turn, shift;
    for (int i = 0; i < 3; ++i) turn[i] = options_.registration_deg * kRadians * random.normal();
    for (int i = 0; i < 3; ++i) shift[i] = options_.registration_mm * random.normal();
    const double angle = turn.norm();
    const Eigen::Matrix3d rotation =
        angle > 0 ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() : Eigen::Matrix3d::Identity();
    const bool moves = angle > 0 || shift.norm() > 0;
    for (Sample& sample : samples) {
      if (moves) sample.position = rotation * (sample.position - box_.center()) + box_.center() + shift;
    }
    if (!options_.cut) return;
    std::erase_if(samples, [&](const Sample& sample) {
      return options_.cut->normal.dot(sample.position) < options_.cut->offset_mm;
    });
  }

  const ScanTarget& target_;
  const ScanOptions& options_;
  std::uint64_t seed_ = 0;
  SurfaceIndex index_;
  ValueNoise hair_patches_;
  Eigen::AlignedBox3d box_;
};

void check(const ScanTarget& target, const ScanOptions& options) {
  CONTRACT(target.materials.size() == target.mesh.positions.size());
  CONTRACT(target.mesh.colours.size() == target.mesh.positions.size());
  const double least = std::min({options.noise_mm, options.hair_noise_mm, options.eye_noise_mm,
                                 options.registration_deg, options.registration_mm, options.spacing_mm});
  if (options.views.empty()) throw InvalidInput("the scanner has no view");
  if (options.points < 1 || options.points > 100'000'000) throw InvalidInput("points must be in 1 .. 1e8");
  if (!(least >= 0)) throw InvalidInput("noise, errors and spacing must not be negative");
  if (!(options.distance_mm > 0)) throw InvalidInput("the camera's distance must be positive");
  if (!(options.outlier_share >= 0 && options.outlier_share < 1)) {
    throw InvalidInput("the share of outliers must be in [0,1)");
  }
}

double choose_spacing(const Scanner& scanner, const ScanOptions& options) {
  if (options.spacing_mm > 0) return options.spacing_mm;
  const double pilot = static_cast<double>(scanner.scan(kPilotSpacingMm, 0).size());
  if (pilot < 1) throw InvalidInput("the scanner sees nothing of the target");
  return kPilotSpacingMm * std::sqrt(pilot / (kSpare * options.points));
}

void shuffle(std::vector<Sample>& samples, std::uint64_t seed) {
  RandomStream random({seed, 0x73687566});
  for (std::size_t i = samples.size(); i > 1; --i) std::swap(samples[i - 1], samples[random.next() % i]);
}

/// Replaces a share of the samples, at random places of the order, by points anywhere about the target.
void scatter_outliers(double share, std::uint64_t seed, std::vector<Sample>& samples) {
  Eigen::AlignedBox3d box;
  for (const Sample& sample : samples) box.extend(sample.position);
  RandomStream random({seed, 0x6f75746c});
  for (Sample& sample : samples) {
    if (random.uniform() >= share) continue;
    for (int i = 0; i < 3; ++i) {
      sample.position[i] = box.center()[i] + 0.6 * box.diagonal()[i] * random.uniform(-1, 1);
    }
  }
}

}  // namespace

std::vector<ScanView> default_scan_views() {
  return {{0, 0}, {45, 0}, {-45, 0}, {90, 0}, {-90, 0}, {0, 48}, {180, 10}};
}

Plane make_capture_plane(double depth_mm, std::uint64_t seed) {
  RandomStream random({seed, 0x706c616e});
  Plane plane;
  plane.normal = Vector3d(random.uniform(-0.06, 0.06), 1, random.uniform(-0.06, 0.06)).normalized();
  plane.offset_mm = -depth_mm;
  return plane;
}

PointCloud scan_surface(const ScanTarget& target, const ScanOptions& options, std::uint64_t seed) {
  check(target, options);
  const Scanner scanner(target, options, seed);
  std::vector<Sample> samples = scanner.scan(choose_spacing(scanner, options), 1);
  if (samples.empty()) throw InvalidInput("the scanner sees nothing of the target");
  shuffle(samples, seed);
  if (samples.size() > static_cast<std::size_t>(options.points)) samples.resize(options.points);
  scatter_outliers(options.outlier_share, seed, samples);
  PointCloud cloud;
  for (const Sample& sample : samples) {
    cloud.positions.push_back(sample.position.cast<float>());
    cloud.colours.push_back(sample.colour);
  }
  return cloud;
}

}  // namespace phiz
