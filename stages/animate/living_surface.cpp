#include "stages/animate/living_surface.h"

#include <algorithm>
#include <string>

#include "stages/animate/surface_kernels.h"
#include "stages/geometry/error.h"

namespace phiz {
namespace {

constexpr int kWholeShare = 8;  ///< with more than 1/8 of the control vertices moved a level is done whole
constexpr double kSmoothing = 0.25;  ///< share of the newest time in what a level is expected to take

SurfaceLevel level_of(const SurfacePlan& plan, int k, const std::vector<float>& displacements,
                      std::vector<Point4>& buffer) {
  return {&plan.level(k), displacements.empty() ? nullptr : displacements.data(), buffer.data(),
          buffer.data() + plan.capacity()};
}

}  // namespace

LivingSurface::LivingSurface(std::shared_ptr<const SurfacePlan> plan,
                             std::span<const std::vector<float>> displacements_mm)
    : plan_(std::move(plan)), displacements_(static_cast<std::size_t>(plan_->level_count()) + 1) {
  for (std::size_t k = 0; k < displacements_.size() && k < displacements_mm.size(); ++k) {
    const std::vector<float>& all = displacements_mm[k];
    const std::size_t count = plan_->vertex_count(static_cast<int>(k));
    if (all.empty()) continue;
    if (all.size() != count)
      throw InvalidInput("level " + std::to_string(k) + " has " + std::to_string(count) + " vertices and " +
                         std::to_string(all.size()) + " displacements");
    displacements_[k].assign(all.begin() + plan_->level(static_cast<int>(k)).first, all.end());
  }
  const std::size_t capacity = plan_->capacity();
  buffer_.resize(2 * capacity);
  for (Dirty* dirty : {&refined_, &displaced_}) {
    dirty->stamps.assign(capacity, 0);
    dirty->list.resize(capacity);
  }
}

std::span<const Point4> LivingSurface::positions() const {
  CONTRACT(level_ >= 0);
  return std::span(buffer_).first(plan_->vertex_count(level_));
}

void LivingSurface::evaluate(std::span<const Eigen::Vector3f> control_positions, int level) {
  CONTRACT(level >= 0 && level <= plan_->level_count());
  CONTRACT(static_cast<int>(control_positions.size()) == plan_->vertex_count(0));
  Point4* raw = buffer_.data() + plan_->capacity();
  for (const Eigen::Vector3f& p : control_positions) *raw++ = {p.x(), p.y(), p.z(), 0};
  for (int k = 0; k <= level; ++k) evaluate_level(k);
  level_ = level;
  updated_ = plan_->vertex_count(level);
  displaced_.count = 0;
  moved_ = kNone;
  ++epoch_;
}

void LivingSurface::evaluate_level(int k) {
  const SurfaceLevel level = level_of(*plan_, k, displacements_[k], buffer_);
  if (k > 0) refine_all(level);
  displace_all(level);
}

void LivingSurface::move(int vertex_idx, const Eigen::Vector3f& position) {
  CONTRACT(level_ >= 0 && vertex_idx >= 0 && vertex_idx < plan_->vertex_count(0));
  buffer_[static_cast<std::size_t>(plan_->capacity()) + vertex_idx] = {position.x(), position.y(),
                                                                       position.z(), 0};
  moved_ = moved_ == kNone || moved_ == vertex_idx ? vertex_idx : kSeveral;
  const SurfacePlan::Level& control = plan_->level(0);
  if (displacements_[0].empty()) return displaced_.add(vertex_idx, epoch_);
  for (int i = control.fan_offsets[vertex_idx]; i < control.fan_offsets[vertex_idx + 1]; ++i)
    displaced_.add(control.fans[i], epoch_);
}

void LivingSurface::refresh(int level) {
  CONTRACT(level_ >= 0 && level <= plan_->level_count() && level >= 0);
  updated_ = 0;
  const int local = std::min(level, level_);
  if (displaced_.count * kWholeShare > plan_->vertex_count(0)) {
    for (int k = 0; k <= local; ++k) evaluate_level(k);
    updated_ = plan_->vertex_count(local);
  } else if (displaced_.count > 0) {
    // Beyond the kept supports the lists of the last level that has them are what to go on from.
    const int kept = moved_ == kSeveral ? -1 : std::min(local, SurfacePlan::kSupportLevels - 1);
    if (kept >= 0) displaced_.count = 0;
    for (int k = 0; k <= kept; ++k) update_support(k, kept < local);
    for (int k = kept + 1; k <= local; ++k) update_level(k);
  }
  for (int k = local + 1; k <= level; ++k) {
    evaluate_level(k);
    updated_ += plan_->level(k).count;
  }
  level_ = level;
  displaced_.count = 0;
  moved_ = kNone;
  ++epoch_;
}

void LivingSurface::update_support(int k, bool is_more_to_come) {
  const SurfaceLevel level = level_of(*plan_, k, displacements_[k], buffer_);
  const SurfacePlan::Support support = plan_->support(moved_, k);
  const int count = static_cast<int>(support.displaced.size());
  if (k > 0) refine_some(level, support.refined.data(), static_cast<int>(support.refined.size()));
  displace_some(level, support.displaced.data(), count);
  updated_ += count;
  if (!is_more_to_come) return;
  std::copy(support.displaced.begin(), support.displaced.end(), displaced_.list.begin() + displaced_.count);
  displaced_.count += count;
}

void LivingSurface::update_level(int k) {
  const SurfaceLevel level = level_of(*plan_, k, displacements_[k], buffer_);
  if (k == 0) {
    displace_some(level, displaced_.list.data(), displaced_.count);
    updated_ += displaced_.count;
    return;
  }
  const SurfacePlan::Level& plan = *level.plan;
  const int before = displaced_.count;
  refined_.count = 0;
  for (int i = 0; i < before; ++i) {
    const int moved = displaced_.list[i];
    for (int j = plan.dependent_offsets[moved]; j < plan.dependent_offsets[moved + 1]; ++j)
      refined_.add(plan.dependents[j], epoch_);
  }
  refine_some(level, refined_.list.data(), refined_.count);
  for (int i = 0; i < refined_.count; ++i) {
    const int moved = refined_.list[i];
    if (level.displacements_mm == nullptr) {
      displaced_.add(moved, epoch_);
      continue;
    }
    for (int j = plan.fan_offsets[moved - plan.first]; j < plan.fan_offsets[moved - plan.first + 1]; ++j)
      displaced_.add(plan.fans[j], epoch_);
  }
  displace_some(level, displaced_.list.data() + before, displaced_.count - before);
  updated_ += displaced_.count - before;
}

std::size_t LivingSurface::bytes_touched(int level) const {
  std::size_t bytes = 0;
  for (int k = 0; k <= level; ++k) {
    const SurfacePlan::Level& plan = plan_->level(k);
    bytes += 2 * sizeof(Point4) * static_cast<std::size_t>(plan.count) + sizeof(int) * plan.rows.size() +
             sizeof(int) * plan.general_offsets.size() +
             (sizeof(int) + sizeof(float)) * plan.general_points.size();
    if (!displacements_[k].empty())
      bytes += sizeof(int) * plan.spokes.size() + sizeof(float) * displacements_[k].size();
  }
  return bytes;
}

void LevelChooser::record(int level, double seconds) {
  CONTRACT(level >= 0 && level < static_cast<int>(seconds_.size()));
  double& expected = seconds_[level];
  expected = expected > 0 ? expected + kSmoothing * (seconds - expected) : seconds;
}

int LevelChooser::choose(double budget_seconds) const {
  int chosen = 0;
  double expected = seconds_[0];
  for (std::size_t k = 1; k < seconds_.size(); ++k) {
    const bool is_known = seconds_[k] > 0;
    if (!is_known && !(expected > 0)) break;  // nothing is known yet: coarse first
    expected = is_known ? seconds_[k] : 4 * expected;
    if (expected <= budget_seconds) chosen = static_cast<int>(k);
  }
  return chosen;
}

}  // namespace phiz
