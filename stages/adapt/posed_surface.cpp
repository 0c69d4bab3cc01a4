#include "stages/adapt/posed_surface.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "stages/geometry/error.h"

namespace phiz {
namespace {

constexpr std::size_t kGrowth = 2;  ///< a group is merged with the one before unless that is so much larger

/// Rows `chosen` of a neutral surface.
NeutralSurface pick(const NeutralSurface& neutral, std::span<const int> chosen) {
  NeutralSurface picked;
  picked.landmarks = neutral.landmarks;
  for (const int i : chosen) {
    picked.uv.push_back(neutral.uv[i]);
    picked.positions.push_back(neutral.positions[i]);
    picked.frames.push_back(neutral.frames[i]);
  }
  return picked;
}

}  // namespace

struct PosedSurface::Group {
  std::vector<int> keys;
  std::vector<Eigen::Vector2d> uv;
  std::unique_ptr<CompiledCascade> cascade;
  std::vector<Eigen::Vector3f> positions;
};

std::vector<int> find_moving_places(const SampledFields& fields) {
  std::vector<int> moving;
  for (std::size_t i = 0; i < fields.point_count; ++i)
    if (fields.offsets[i + 1] > fields.offsets[i]) moving.push_back(static_cast<int>(i));
  return moving;
}

PosedSurface::PosedSurface(const Deformation& rig, const UvChart& chart, NeutralSurface neutral,
                           SurfacePoints& points)
    : rig_(rig),
      chart_(chart),
      neutral_(std::move(neutral)),
      points_(points),
      plain_(rig, neutral_.landmarks),
      parameters_(rig.parameters.size(), 0.0f),
      plain_parameters_(rig.parameters.size(), 0.0) {
  CONTRACT(neutral_.uv.size() == chart.uv.size());
  const NeutralSurface at_points = pick(neutral_, points.vertices);
  for (const int i : find_moving_places(sample_fields(rig_, at_points.uv))) moving_.push_back(i);
  points.may_move.assign(points.uv.size(), 0);
  for (const int i : moving_) points.may_move[i] = 1;
  NeutralSurface at_moving = pick(at_points, moving_);
  if (moving_.empty()) return;
  moving_cascade_ = std::make_unique<CompiledCascade>(rig_, sample_fields(rig_, at_moving.uv), at_moving);
  moved_.resize(moving_.size());
}

PosedSurface::~PosedSurface() = default;

NeutralSurface PosedSurface::neutral_at(std::span<const Eigen::Vector2d> uv) const {
  NeutralSurface made;
  made.landmarks = neutral_.landmarks;
  for (const Eigen::Vector2d& place : uv) {
    const SurfacePoint point = refine_place(chart_.domain.locate(place), chart_.level);
    const Eigen::Vector3i& t = chart_.hierarchy.triangles(chart_.level)[point.triangle_idx];
    const Eigen::Vector3f w = point.weights.cast<float>();
    made.uv.push_back(place);
    made.positions.push_back(w[0] * neutral_.positions[t[0]] + w[1] * neutral_.positions[t[1]] +
                             w[2] * neutral_.positions[t[2]]);
    const Eigen::Matrix3f frame =
        w[0] * neutral_.frames[t[0]] + w[1] * neutral_.frames[t[1]] + w[2] * neutral_.frames[t[2]];
    made.frames.push_back(Eigen::Quaternionf(frame).normalized().toRotationMatrix());
  }
  return made;
}

void PosedSurface::compile_group(const std::vector<int>& keys) {
  auto group = std::make_unique<Group>();
  group->keys = keys;
  for (const int v : keys) group->uv.push_back(known_[v].uv);
  const NeutralSurface neutral = neutral_at(group->uv);
  group->cascade = std::make_unique<CompiledCascade>(rig_, sample_fields(rig_, group->uv), neutral);
  group->positions.resize(keys.size());
  groups_.push_back(std::move(group));
}

/// What came since the last pose becomes a group, together with groups that are not much larger, without
/// what is gone: there are few groups, and a place is compiled few times.
void PosedSurface::gather_groups() {
  while (!groups_.empty() && !fresh_.empty() && groups_.back()->keys.size() <= kGrowth * fresh_.size()) {
    for (const int key : groups_.back()->keys)
      if (known_[key].used == pose_) fresh_.push_back(key);
    groups_.pop_back();
  }
  std::sort(fresh_.begin(), fresh_.end());
  fresh_.erase(std::unique(fresh_.begin(), fresh_.end()), fresh_.end());
  if (!fresh_.empty()) compile_group(fresh_);
  fresh_.clear();
}

void PosedSurface::set_pose(std::span<const float> parameters) {
  CONTRACT(parameters.size() == rig_.parameters.size());
  gather_groups();
  ++pose_;
  parameters_.assign(parameters.begin(), parameters.end());
  plain_parameters_.assign(parameters.begin(), parameters.end());
  if (moving_cascade_) moving_cascade_->evaluate(parameters_, moved_);
  for (std::size_t i = 0; i < moving_.size(); ++i) points_.positions[moving_[i]] = moved_[i];
  for (const auto& group : groups_) {
    group->cascade->evaluate(parameters_, group->positions);
    for (std::size_t i = 0; i < group->keys.size(); ++i) {
      Known& known = known_[group->keys[i]];
      if (known.uv != group->uv[i]) continue;  // the slot has another vertex by now
      known.sample.position = group->positions[i];
      known.pose = pose_;
    }
  }
}

Eigen::Vector3f PosedSurface::evaluate_at(const Eigen::Vector2d& uv) const {
  const Eigen::Vector2d places[] = {uv};
  const NeutralSurface neutral = neutral_at(places);
  SurfaceSample place;
  place.uv = uv;
  place.position = neutral.positions[0].cast<double>();
  place.frame = neutral.frames[0].cast<double>();
  return plain_.evaluate(plain_parameters_, place).cast<float>();
}

VertexSample PosedSurface::sample(int key, const Eigen::Vector2d& uv) {
  if (key < 0) return {evaluate_at(uv), Eigen::Vector3f::UnitZ()};
  if (key >= static_cast<int>(known_.size())) known_.resize(key + 1);
  Known& known = known_[key];
  known.used = pose_;
  if (known.uv == uv && known.pose == pose_ && pose_ > 0) return known.sample;
  known.uv = uv;
  known.pose = pose_;
  known.sample.position = evaluate_at(uv);
  fresh_.push_back(key);
  return known.sample;
}

}  // namespace phiz
