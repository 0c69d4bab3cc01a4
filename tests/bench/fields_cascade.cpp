#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <random>

#include "tests/bench/fields.h"

namespace phiz::bench {
namespace {

constexpr std::size_t kPoints = 80'000, kFields = 52;
constexpr int kRuns = 21;

/// Processor time of this thread: what others do with the machine shows less.
double seconds_now() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Median of the runs after one warm-up.
template <typename Work>
double time_of(const Work& work) {
  work();
  std::vector<double> times;
  for (int run = 0; run < kRuns; ++run) {
    const double start = seconds_now();
    work();
    times.push_back(seconds_now() - start);
  }
  return median(times);
}

constexpr std::size_t kFloats = 12u << 20;  ///< an array far larger than the caches of a core

/// Bytes a second that one thread reads in order: what the cascade mostly does.
double measure_reading() {
  constexpr std::size_t kLanes = 16;
  const std::vector<float> values(kFloats, 1.0f);
  float total = 0;
  const double time = time_of([&] {
    std::array<float, kLanes> sums{};
    for (std::size_t i = 0; i < kFloats; i += kLanes) {
      for (std::size_t k = 0; k < kLanes; ++k) sums[k] += values[i + k];
    }
    for (const float sum : sums) total += sum;
  });
  return total > 0 ? sizeof(float) * static_cast<double>(kFloats) / time : 0;
}

/// a = b + s c, one thread: bytes a second.
double measure_triad() {
  std::vector<float> a(kFloats, 0.0f), b(kFloats, 1.0f), c(kFloats, 2.0f);
  float s = 0.5f;
  const double time = time_of([&] {
    for (std::size_t i = 0; i < kFloats; ++i) a[i] = b[i] + s * c[i];
    s += a[kFloats / 2] * 1e-9f;
  });
  return 3.0 * sizeof(float) * static_cast<double>(kFloats) / time;
}

NeutralSurface first_points(NeutralSurface neutral, std::size_t count) {
  neutral.uv.resize(count);
  neutral.positions.resize(count);
  neutral.frames.resize(count);
  return neutral;
}

/// The rig's first 52 fields behind the neutral surface.
Deformation some_fields(Deformation rig) {
  rig.fields.resize(kFields + 1);
  rig.output = rig.fields.back().name;
  rig.controls.clear();
  return rig;
}

/// 52 fields that are nowhere zero.
Deformation dense_fields() {
  constexpr int kSide = 33;
  std::mt19937_64 dice(7);
  Deformation rig;
  rig.width = rig.height = kSide;
  rig.fields.resize(kFields + 1);
  rig.fields[0].name = "neutral";
  rig.fields[0].type = FieldType::kConstant;
  for (std::size_t f = 1; f <= kFields; ++f) {
    DeformationField& field = rig.fields[f];
    field.name = field.parameter = "f" + std::to_string(f);
    field.inputs = {rig.fields[f - 1].name};
    std::vector<float> values;
    for (int i = 0; i < 3 * kSide * kSide; ++i)
      values.push_back(1.0f + static_cast<float>(dice() % 1000) * 1e-3f);
    field.image = crop_field_image(kSide, kSide, 3, values);
    rig.parameters.push_back({field.name, 0, 1});
  }
  rig.output = rig.fields.back().name;
  return rig;
}

void report(const FieldsWorld& world, const std::string& what, const Deformation& rig,
            const NeutralSurface& neutral, double bandwidth, const Bar& share) {
  const CompiledCascade cascade(rig, sample_fields(rig, neutral.uv), neutral);
  std::vector<float> parameters;
  for (std::size_t k = 0; k < rig.parameters.size(); ++k)
    parameters.push_back(0.2f + 0.01f * static_cast<float>(k));
  std::vector<Eigen::Vector3f> positions(neutral.positions.size());
  const double time = time_of([&] { cascade.evaluate(parameters, positions); });
  const double plain = time_of([&] { cascade.evaluate(parameters, positions, VectorPath::kPlain); });
  const double bytes = static_cast<double>(cascade.bytes_touched(parameters));
  world.bench.board.note(fmt::format("{}: {:.1f} MB touched a frame, {:.1f} GB/s; without AVX2 {:.2f} ms",
                                     what, bytes / 1e6, bytes / time / 1e9, plain * 1e3));
  world.bench.board.add({what + ", one core, a frame", time * 1e3, "ms", at_most(2)});
  world.bench.board.add(
      {what + ", share of the memory bandwidth", 100 * bytes / time / bandwidth, "%", share});
}

}  // namespace

void measure_cascade_speed(const FieldsWorld& world) {
  const NeutralMaker maker(world.bench.head.mesh, 3);
  const NeutralSurface neutral =
      first_points(maker.make(world.bench.head.mesh.positions, {}), std::min(kPoints, maker.uv().size()));
  world.bench.board.add({"memory bandwidth, one thread, triad", measure_triad() / 1e9, "GB/s", {}});
  const double bandwidth = measure_reading();
  world.bench.board.add({"memory bandwidth, one thread, reading", bandwidth / 1e9, "GB/s", {}});
  report(world, "cascade of 52 muscles on 80,000 points", some_fields(world.rig), neutral, bandwidth,
         at_least(60));
  report(world, "the same with fields that are nowhere zero", dense_fields(), neutral, measure_reading(),
         Bar{});
}

void measure_exactness(const FieldsWorld& world) {
  const NeutralMaker maker(world.bench.head.mesh, 2);
  const SampledFields fields = sample_fields(world.rig, maker.uv());
  std::vector<float> left(world.rig.controls.size(), 0.0f);
  left.at(static_cast<std::size_t>(find_control(world.rig, "mouthSmileLeft"))) = 1;
  double differing = 0, right_mm = 0, left_mm = 0;
  int subjects = 0;
  for (const BenchSubject& subject : world.bench.data.subjects) {
    const auto run = world.fits.subjects.find(subject.name);
    if (run == world.fits.subjects.end() || !run->second.is_done) continue;
    const NeutralSurface neutral = load_neutral(world, subject.name, maker);
    const CompiledCascade cascade(world.rig, fields, neutral);
    std::vector<Eigen::Vector3f> positions(neutral.positions.size());
    cascade.evaluate(std::vector<float>(world.rig.parameters.size(), 0.0f), positions);
    for (std::size_t i = 0; i < positions.size(); ++i)
      differing += std::memcmp(positions[i].data(), neutral.positions[i].data(), sizeof(positions[i])) != 0;
    cascade.evaluate(parameters_of_controls(world.rig, left), positions);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const double way = (positions[i] - neutral.positions[i]).cast<double>().norm();
      if (neutral.uv[i].x() < 0.5)
        right_mm = std::max(right_mm, way);
      else
        left_mm = std::max(left_mm, way);
    }
    ++subjects;
  }
  world.bench.board.note(fmt::format("{} fitted subjects", subjects));
  world.bench.board.add(
      {"neutral parameters: vertices that are not the neutral surface's bits", differing, "", at_most(0)});
  world.bench.board.add({"left smile: largest way on the left half", left_mm, "mm", at_least(5)});
  world.bench.board.add({"left smile: largest way on the right half", right_mm, "mm", at_most(0.2)});
}

}  // namespace phiz::bench
