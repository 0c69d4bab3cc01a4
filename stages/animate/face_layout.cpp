#include "stages/animate/face_layout.h"

#include <algorithm>
#include <cmath>

#include "stages/animate/skin_paths.h"
#include "stages/geometry/error.h"

namespace phiz {
namespace {

constexpr double kSampleMm = 1.5;  ///< distance of the places along a fibre that skin is measured from

/// 1 within plateau * radius, 0 beyond the radius, smooth between.
double fade(double distance, double radius, double plateau) {
  const double t = std::clamp((distance / radius - plateau) / (1 - plateau), 0.0, 1.0);
  return (1 - t * t) * (1 - t * t);
}

/// The nearest place of a polyline as a share of its length.
double find_along(const std::vector<Eigen::Vector3d>& line, const Eigen::Vector3d& place) {
  double length = 0, best = 0, best_distance = INFINITY;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Eigen::Vector3d way = line[i + 1] - line[i];
    const double t = std::clamp((place - line[i]).dot(way) / std::max(way.squaredNorm(), 1e-12), 0.0, 1.0);
    const double distance = (line[i] + t * way - place).norm();
    if (distance < best_distance) best_distance = distance, best = length + t * way.norm();
    length += way.norm();
  }
  return length > 0 ? best / length : 1;
}

}  // namespace

class FaceLayout::Builder {
 public:
  Builder(const ControlMesh& head, const FaceAnatomy& anatomy, FaceLayout& layout)
      : head_(head), anatomy_(anatomy), layout_(layout), paths_(head.positions, head.triangles) {}

  void build() {
    part_ = "condyles and loose regions";
    layout_.place(anatomy_.condyle_left, false, head_.positions);
    layout_.place(anatomy_.condyle_right, false, head_.positions);
    layout_.loose_.assign(head_.positions.size(), false);
    for (const std::string& name : anatomy_.loose)
      for (const int v : region(name)) layout_.loose_[v] = true;
    add_ties();
    for (const JawMotion& motion : anatomy_.jaw)
      layout_.maxima_.push_back(1.2f), layout_.jaw_.push_back(motion);
    for (const FaceMuscle& muscle : anatomy_.muscles)
      for_sides("muscle " + muscle.name, muscle.is_pair,
                [&](bool mirrored) { add_muscle(muscle, mirrored); });
    for (const SkinRim& rim : anatomy_.rims)
      for_sides("rim " + rim.name, rim.is_pair, [&](bool mirrored) { add_rim(rim, mirrored); });
    for (const SkinVolume& volume : anatomy_.volumes)
      for_sides("volume " + volume.name, volume.is_pair,
                [&](bool mirrored) { add_volume(volume, mirrored); });
  }
  const std::string& part() const { return part_; }

 private:
  template <class Add>
  void for_sides(const std::string& part, bool is_pair, const Add& add) {
    part_ = part;
    if (is_pair && head_.annotations.mirror.empty())
      throw InvalidInput("is a pair, and the head has no mirror map");
    add(false);
    if (is_pair) add(true);
  }

  int mirrored(int v, bool is_mirrored) const { return is_mirrored ? head_.annotations.mirror[v] : v; }
  const std::vector<int>& region(const std::string& name) const {
    const auto found = head_.annotations.regions.find(name);
    if (found == head_.annotations.regions.end()) throw InvalidInput("the head has no region '" + name + "'");
    return found->second;
  }
  /// On the left where the part is one of a pair, the mirror image of that on the right.
  bool is_on_side(int v, bool is_pair, bool is_mirrored) const {
    return !is_pair || (head_.positions[v].x() > 0) != is_mirrored;
  }

  std::vector<double> weigh(const SkinZone& zone, bool is_pair, bool is_mirrored) const {
    std::vector<std::pair<int, double>> seeds;
    for (const LandmarkPoint& point : zone.points)
      seeds.emplace_back(paths_.nearest(layout_.place(point, is_mirrored, head_.positions)), 0.0);
    if (!zone.region.empty())
      for (const int v : region(zone.region))
        if (is_on_side(v, is_pair, is_mirrored)) seeds.emplace_back(v, 0.0);
    std::vector<double> weights = paths_.distances(seeds);
    for (double& w : weights) w = fade(w, zone.radius_mm, zone.plateau);
    return weights;
  }

  void add_ties() {
    const std::size_t count = head_.positions.size();
    std::vector<double> skull(count, 1.0), jaw(count, 0.0);
    for (const SkinTie& tie : anatomy_.ties) {
      for_sides("tie", tie.is_pair, [&](bool is_mirrored) {
        const std::vector<double> weights = weigh(tie.zone, tie.is_pair, is_mirrored);
        for (std::size_t v = 0; v < count; ++v) {
          const double w = weights[v];
          if (tie.kind == SkinTie::Kind::kSlack) skull[v] *= 1 - tie.amount * w, jaw[v] *= 1 - tie.amount * w;
          if (tie.kind == SkinTie::Kind::kSkull) skull[v] += (tie.amount - skull[v]) * w;
          if (tie.kind == SkinTie::Kind::kJaw) skull[v] *= 1 - w, jaw[v] = std::max(jaw[v], tie.amount * w);
        }
      });
    }
    for (std::size_t v = 0; v < count; ++v) {
      layout_.skull_ties_.push_back(static_cast<float>(std::max(skull[v], 0.0)));
      layout_.jaw_ties_.push_back(static_cast<float>(jaw[v]));
    }
  }

  void add_muscle(const FaceMuscle& shape, bool is_mirrored) {
    Muscle muscle{shape, is_mirrored, {}, {}, false};
    if (shape.kind == FaceMuscle::Kind::kSphincter) {
      layout_.place(shape.line_from, is_mirrored, head_.positions);
      layout_.place(shape.line_to, is_mirrored, head_.positions);
      const std::vector<double> weights = weigh(shape.zone, shape.is_pair, is_mirrored);
      for (int v = 0; v < static_cast<int>(weights.size()); ++v)
        if (weights[v] > 0) muscle.shares.push_back({v, static_cast<float>(weights[v]), 0, 1});
    } else {
      add_fibres(muscle);
    }
    if (!shape.retreat_region.empty())
      for (const int v : region(shape.retreat_region))
        if (is_on_side(v, shape.is_pair, is_mirrored)) muscle.retreating.push_back(v);
    if (muscle.shares.empty()) throw InvalidInput("pulls no vertex");
    layout_.maxima_.push_back(static_cast<float>(shape.maximum));
    layout_.muscles_.push_back(std::move(muscle));
  }

  void add_fibres(Muscle& muscle) {
    std::vector<Share> best(head_.positions.size());
    for (std::size_t f = 0; f < muscle.shape.fibres.size(); ++f) {
      std::vector<Eigen::Vector3d> line;
      for (const LandmarkPoint& point : muscle.shape.fibres[f])
        line.push_back(layout_.place(point, muscle.is_mirrored, head_.positions));
      const std::vector<double> distances = paths_.distances(seeds_of(line));
      for (int v = 0; v < static_cast<int>(best.size()); ++v) {
        const double along = find_along(line, head_.positions[v]);
        // Skin moves with the fibre in proportion to its way from the bone.
        const double influence = fade(distances[v], muscle.shape.radius_mm, muscle.shape.plateau) * along;
        if (influence > best[v].influence)
          best[v] = {v, static_cast<float>(influence), static_cast<int>(f), static_cast<float>(along)};
      }
      const int origin = paths_.nearest(line.front());
      muscle.is_on_jaw = layout_.jaw_ties_[origin] > layout_.skull_ties_[origin];
    }
    for (const Share& share : best)
      if (share.influence > 1e-3f) muscle.shares.push_back(share);
  }

  std::vector<std::pair<int, double>> seeds_of(const std::vector<Eigen::Vector3d>& line) const {
    std::vector<std::pair<int, double>> seeds;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      const int steps = std::max(1, static_cast<int>((line[i + 1] - line[i]).norm() / kSampleMm));
      for (int k = 0; k <= steps; ++k)
        seeds.emplace_back(paths_.nearest(line[i] + (line[i + 1] - line[i]) * k / steps), 0.0);
    }
    return seeds;
  }

  std::vector<int> trace(const std::vector<std::string>& names, bool is_mirrored) const {
    std::vector<int> way;
    for (const std::string& name : names) {
      const int v = paths_.nearest(layout_.place({{name, 1.0}}, is_mirrored, head_.positions));
      if (way.empty()) {
        way.push_back(v);
        continue;
      }
      const std::vector<int> piece = paths_.path(way.back(), v);
      if (piece.empty()) throw InvalidInput("no way along the skin to '" + name + "'");
      way.insert(way.end(), piece.begin() + 1, piece.end());
    }
    return way;
  }

  void add_rim(const SkinRim& rim, bool is_mirrored) {
    Rim result{rim.name + (rim.is_pair ? is_mirrored ? "Right" : "Left" : ""), trace(rim.upper, is_mirrored),
               trace(rim.lower, is_mirrored)};
    if (result.upper.front() != result.lower.front() || result.upper.back() != result.lower.back())
      throw InvalidInput("its two sides do not meet in the corners");
    layout_.rims_.push_back(std::move(result));
  }

  void add_volume(const SkinVolume& volume, bool is_mirrored) {
    Volume result{volume.name, volume.stiffness, {}};
    const std::vector<double> weights = weigh(volume.zone, volume.is_pair, is_mirrored);
    for (int v = 0; v < static_cast<int>(weights.size()); ++v)
      if (weights[v] > 0) result.shares.emplace_back(v, weights[v]);
    layout_.volumes_.push_back(std::move(result));
  }

  const ControlMesh& head_;
  const FaceAnatomy& anatomy_;
  FaceLayout& layout_;
  SkinPaths paths_;
  std::string part_;
};

FaceLayout::FaceLayout(const ControlMesh& generic_head, const FaceAnatomy& anatomy)
    : activations_(activation_names(anatomy)),
      triangles_(generic_head.triangles),
      landmarks_(generic_head.annotations.landmarks),
      mirror_(generic_head.annotations.mirror),
      condyle_right_(anatomy.condyle_right),
      condyle_left_(anatomy.condyle_left),
      expressions_(anatomy.expressions),
      controls_(anatomy.controls) {
  Builder builder(generic_head, anatomy, *this);
  try {
    builder.build();
  } catch (const InvalidInput& error) {
    throw InvalidInput("anatomy: " + builder.part() + ": " + error.what());
  }
}

Eigen::Vector3d FaceLayout::place(const LandmarkPoint& point, bool is_mirrored,
                                  std::span<const Eigen::Vector3d> positions) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& [name, weight] : point) {
    const auto found = landmarks_.find(name);
    if (found == landmarks_.end()) throw InvalidInput("the head has no landmark '" + name + "'");
    const Eigen::Vector3i& corners = triangles_[found->second.triangle_idx];
    for (int i = 0; i < 3; ++i) {
      const int v = is_mirrored ? mirror_[corners[i]] : corners[i];
      sum += weight * found->second.weights[i] * positions[v];
    }
  }
  return sum;
}

Eigen::Vector3d FaceLayout::condyle(bool is_left, std::span<const Eigen::Vector3d> positions) const {
  return place(is_left ? condyle_left_ : condyle_right_, false, positions);
}

const Activations* FaceLayout::find_control(const std::string& name) const {
  const auto found = controls_.find(name);
  return found == controls_.end() ? nullptr : &found->second;
}

const Activations* FaceLayout::find_expression(const std::string& name) const {
  const auto found = expressions_.find(name);
  return found == expressions_.end() ? nullptr : &found->second;
}

int FaceLayout::find_activation(const std::string& name) const {
  const auto found = std::find(activations_.begin(), activations_.end(), name);
  return found == activations_.end() ? -1 : static_cast<int>(found - activations_.begin());
}

}  // namespace phiz
