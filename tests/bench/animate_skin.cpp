#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <random>
#include <stdexcept>

#include "tests/bench/animate.h"

namespace phiz::bench {
namespace {

constexpr int kRandomSteps = 100'000, kStepsASequence = 50;
constexpr double kDriftPercent = 1;

std::shared_ptr<const FaceLayout> load_layout(const GenericHead& head) {
  std::ifstream in(PHIZ_SOURCE_FOLDER "/samples/anatomy/face.json");
  return std::make_shared<const FaceLayout>(head.mesh, read_face_anatomy(in));
}

std::vector<Eigen::Vector3d> widen(const AnimateSubject& subject) {
  std::vector<Eigen::Vector3d> control;
  for (const Eigen::Vector3f& p : subject.control) control.push_back(p.cast<double>());
  return control;
}

/// Half of the activations at random, the others 0.
std::vector<float> roll(std::mt19937& generator, const FaceLayout& layout) {
  std::vector<float> values(layout.activations().size(), 0.0f);
  for (float& value : values)
    if (generator() % 2 == 0) value = static_cast<float>(generator() % 1001) / 1000;
  return values;
}

void measure_speed(const AnimateWorld& world, const std::shared_ptr<const FaceLayout>& layout) {
  const AnimateSubject& subject = world.subjects.front();
  Skin skin(layout, widen(subject));
  LivingSurface surface(world.plan, subject.displacements_mm);
  std::mt19937 generator(3);
  std::vector<std::vector<float>> poses;
  for (int i = 0; i < 16; ++i) {
    poses.push_back(roll(generator, *layout));
    for (float& value : poses.back()) value = std::max(value, 0.01f);  // every muscle at work
  }
  int frame = 0;
  const auto step = [&] {
    skin.set_activations(poses[++frame / 10 % poses.size()]);
    skin.step(1.0 / 60);
  };
  const RunTimes alone = measure_times(300, step);
  const RunTimes both = measure_times(300, [&] {
    step();
    surface.evaluate(skin.positions(), 2);
  });
  Board& board = world.bench.board;
  board.add({fmt::format("step of the skin, {} activations, {} vertices", layout->activations().size(),
                         subject.control.size()),
             1e3 * alone.median_s, "ms", at_most(1)});
  board.add({"frames a second with the level-2 surface", 1 / both.median_s, "1/s", at_least(500)});
}

struct Wear {
  int broken = 0, turned = 0;
  double crossing_mm = 0, left_mm = 0;
};

/// Sequences of random activations and steps, a second of rest after each hundredth.
Wear wear_out(Skin& skin, int steps) {
  std::mt19937 generator(5);
  Wear wear;
  const std::vector<float> none(skin.layout().activations().size(), 0.0f);
  skin.reset();
  int held = 0;
  for (int i = 0; i < steps; ++i) {
    if (--held < 0) {
      skin.set_activations(roll(generator, skin.layout()));
      held = static_cast<int>(generator() % 12);
    }
    const double share = static_cast<double>(generator() % 1001) / 1000;
    skin.step(std::pow(1.0 / 24, share) * std::pow(1.0 / 240, 1 - share));
    const Skin::Figures figures = skin.measure();
    wear.broken += !std::isfinite(figures.elastic + figures.kinetic);
    wear.crossing_mm = std::max(wear.crossing_mm, figures.crossing_mm);
    wear.turned = std::max(wear.turned, skin.count_turned());
    if (i % (100 * kStepsASequence) != 100 * kStepsASequence - 1) continue;
    skin.set_activations(none);
    for (int k = 0; k < 240; ++k) skin.step(1.0 / 60);
    held = 0;
    wear.left_mm = std::max(wear.left_mm, skin.measure().farthest_mm);
  }
  return wear;
}

void measure_wear(const AnimateWorld& world, const std::shared_ptr<const FaceLayout>& layout) {
  Board& board = world.bench.board;
  for (const AnimateSubject& subject : world.subjects) {
    Skin skin(layout, widen(subject));
    const int steps = kRandomSteps / static_cast<int>(world.subjects.size());
    const Wear wear = wear_out(skin, steps);
    const std::string of =
        fmt::format("{}, {} random activations, steps of 1/24 to 1/240 s: ", subject.name, steps);
    board.add({of + "not a number", static_cast<double>(wear.broken), "", at_most(0)});
    board.add({of + "faces turned by more than 90 degrees, most at once", static_cast<double>(wear.turned),
               "", at_most(0)});
    board.add({of + "lips or lids through each other", wear.crossing_mm, "mm", at_most(0.2)});
    board.add({of + "left of it after 4 s without", wear.left_mm, "mm", at_most(0.01)});
  }
}

/// Free skin, no damping, midpoint rule: a second of flight, turning and swinging.
void measure_conservation(const AnimateWorld& world, const std::shared_ptr<const FaceLayout>& layout) {
  SkinOptions options;
  options.is_tied = false;
  options.damping_s = 0;
  options.dissipation = 0;
  options.rounds = 60;
  options.bend_mm2 = 0;  // the bending term knows no rotation: angular momentum is the springs' own
  Skin skin(layout, widen(world.subjects.front()), options);
  std::vector<Eigen::Vector3f> velocities;
  for (const Eigen::Vector3f& p : skin.rest_positions())
    velocities.emplace_back(20 + 0.5f * p.y(), -0.5f * p.x(), 10 * std::sin(0.05f * p.y()));
  skin.set_velocities(velocities);
  const Skin::Figures before = skin.measure();
  for (int i = 0; i < 240; ++i) skin.step(1.0 / 240);
  const Skin::Figures after = skin.measure();
  const double energy = before.kinetic + before.elastic;
  Board& board = world.bench.board;
  board.add({"momentum, drift in a second without muscles or damping",
             100 * (after.momentum - before.momentum).norm() / before.momentum.norm(), "%",
             at_most(kDriftPercent)});
  board.add({"angular momentum, likewise",
             100 * (after.angular_momentum - before.angular_momentum).norm() / before.angular_momentum.norm(),
             "%", at_most(kDriftPercent)});
  board.add({"energy, likewise", 100 * std::abs(after.kinetic + after.elastic - energy) / energy, "%",
             at_most(kDriftPercent)});
}

}  // namespace

void measure_skin(const AnimateWorld& world) {
  const auto layout = load_layout(world.bench.head);
  world.bench.board.note("skin with the muscles of samples/anatomy/face.json, one thread, processor time");
  measure_speed(world, layout);
  measure_conservation(world, layout);
  measure_wear(world, layout);
}

}  // namespace phiz::bench
