#include "stages/animate/skin.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "stages/animate/skin_state.h"
#include "stages/geometry/error.h"

namespace phiz {

Skin::Skin(std::shared_ptr<const FaceLayout> layout, std::span<const Eigen::Vector3d> rest,
           const SkinOptions& options) {
  if (static_cast<int>(rest.size()) != layout->vertex_count())
    throw InvalidInput("the head has " + std::to_string(rest.size()) + " control vertices, the anatomy's " +
                       std::to_string(layout->vertex_count()));
  CONTRACT(options.rounds > 0 && options.stiff_ratio >= 1 && options.density > 0);
  state_ = std::make_unique<State>(std::move(layout), rest, options);
}

Skin::~Skin() = default;
Skin::Skin(Skin&&) noexcept = default;

void Skin::set_activations(std::span<const float> activations) {
  CONTRACT(activations.size() == state_->layout->activations().size());
  if (state_->options.is_tied) state_->set_activations(activations);
}

void Skin::step(double seconds) {
  CONTRACT(seconds > 0);
  state_->step(seconds);
}

void Skin::relax(int rounds) {
  state_->relax(rounds);
}

void Skin::reset() {
  state_->reset();
}

void Skin::set_velocities(std::span<const Eigen::Vector3f> velocities) {
  CONTRACT(velocities.size() == state_->velocity.size());
  for (std::size_t v = 0; v < velocities.size(); ++v)
    state_->velocity[v] = {velocities[v].x(), velocities[v].y(), velocities[v].z(), 0};
}

std::span<const Eigen::Vector3f> Skin::positions() const {
  return state_->positions;
}
std::span<const Eigen::Vector3f> Skin::rest_positions() const {
  return state_->rest_positions;
}
const FaceLayout& Skin::layout() const {
  return *state_->layout;
}
Skin::Figures Skin::measure() const {
  return state_->measure();
}

int Skin::count_turned() const {
  int turned = 0;
  for (const Eigen::Vector3i& t : state_->visible_triangles) {
    const auto normal = [&](const std::vector<Eigen::Vector3f>& p) {
      return Eigen::Vector3f((p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]));
    };
    turned += normal(state_->positions).dot(normal(state_->rest_positions)) < 0;
  }
  return turned;
}

}  // namespace phiz
