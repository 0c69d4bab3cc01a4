#include <algorithm>
#include <array>
#include <cmath>

#include "stages/deform/cascade_plan.h"
#include "stages/deform/compiled_cascade.h"
#include "stages/deform/deform.h"
#include "stages/geometry/error.h"

namespace phiz {
namespace {

constexpr int kPoints = CompiledCascade::kBlockPoints;
constexpr double kLargest = 32767;

}  // namespace

/// Makes a compiled cascade, part by part.
struct CascadeCompiler {
  using Kind = CompiledCascade::Kind;
  using Operation = CompiledCascade::Operation;

  const CascadePlan& plan;
  const SampledFields& fields;
  const NeutralSurface& neutral;
  CompiledCascade& made;
  std::vector<int> places;  ///< of each point in the blocks
  std::vector<int> slots;   ///< of each step's result

  std::size_t block_count() const { return (places.size() + kPoints - 1) / kPoints; }

  void order_points() {
    made.order_ = fields.order;
    places.resize(made.order_.size());
    for (std::size_t i = 0; i < places.size(); ++i) places[made.order_[i]] = static_cast<int>(i);
    made.neutral_.resize(block_count() * 3 * kPoints);
    for (std::size_t i = 0; i < block_count() * kPoints; ++i) {
      const Eigen::Vector3f& p = neutral.positions[made.order_[std::min(i, places.size() - 1)]];
      for (int c = 0; c < 3; ++c) made.neutral_[3 * i + c] = p[c];
    }
  }

  /// One buffer a result that is still needed; what has one user is changed in place.
  void assign_operations() {
    std::vector<int> users(plan.steps.size(), 0);
    for (const CascadeStep& step : plan.steps) {
      if (step.first >= 0) ++users[step.first];
      if (step.second >= 0) ++users[step.second];
    }
    ++users.back();
    slots.assign(plan.steps.size(), -1);
    std::array<bool, CompiledCascade::kMostSlots> used{};
    const auto take = [&used] {
      const auto free = std::find(used.begin(), used.end(), false);
      if (free == used.end()) throw InvalidInput("the cascade needs more than 8 intermediate surfaces");
      *free = true;
      return static_cast<int>(free - used.begin());
    };
    for (std::size_t s = 0; s < plan.steps.size(); ++s) {
      const CascadeStep& step = plan.steps[s];
      if (step.first < 0) {
        slots[s] = take();
      } else if (--users[step.first] == 0) {
        slots[s] = slots[step.first];
      } else {
        slots[s] = take();
        Operation copy;
        copy.kind = Kind::kCopy;
        copy.slot = slots[s];
        copy.source = slots[step.first];
        made.operations_.push_back(copy);
      }
      append(step, static_cast<int>(s));
      if (step.second >= 0 && --users[step.second] == 0 && slots[step.second] != slots[s])
        used[slots[step.second]] = false;
    }
    made.result_slot_ = slots.back();
  }

  void append(const CascadeStep& step, int index) {
    Operation operation;
    operation.slot = slots[index];
    operation.steps = {index};
    switch (step.type) {
      case FieldType::kConstant:
        operation.kind = step.is_neutral ? Kind::kNeutral : Kind::kConstant;
        if (!step.is_neutral) operation.constant = add_constant(step);
        break;
      case FieldType::kAdd:
      case FieldType::kAddLocal:
        operation.kind = Kind::kLinear;
        break;
      case FieldType::kRotate:
        operation.kind = Kind::kRotate;
        operation.axis_point = step.axis_point.cast<float>();
        operation.axis_direction = step.axis_direction.cast<float>();
        break;
      case FieldType::kBlend:
        operation.kind = Kind::kBlend;
        operation.source = slots[step.second];
        break;
    }
    if (!made.operations_.empty() && can_fuse(made.operations_.back(), operation))
      made.operations_.back().steps.push_back(index);
    else
      made.operations_.push_back(operation);
  }

  static bool can_fuse(const Operation& last, const Operation& next) {
    if (last.kind != next.kind || last.slot != next.slot) return false;
    if (next.kind == Kind::kLinear) return true;
    return next.kind == Kind::kRotate && last.axis_point == next.axis_point &&
           last.axis_direction == next.axis_direction;
  }

  int add_constant(const CascadeStep& step) {
    std::vector<float> values(block_count() * 3 * kPoints, 0.0f);
    const SampledFields::Field& field = fields.fields[step.field_idx];
    for (std::size_t k = 0; k < field.points.size(); ++k) {
      for (int c = 0; c < 3; ++c) values[3 * places[field.points[k]] + c] = field.values[k][c];
    }
    made.constants_.push_back(std::move(values));
    return static_cast<int>(made.constants_.size()) - 1;
  }

  /// The field's values in the subject's axes, one a sampled point.
  std::vector<Eigen::Vector3f> values_of(const CascadeStep& step) const {
    const SampledFields::Field& field = fields.fields[step.field_idx];
    std::vector<Eigen::Vector3f> values = field.values;
    if (step.type == FieldType::kAddLocal) {
      for (std::size_t k = 0; k < values.size(); ++k) values[k] = neutral.frames[field.points[k]] * values[k];
    }
    return values;
  }

  double lever_of(const CascadeStep& step) const {
    if (step.type != FieldType::kRotate && step.type != FieldType::kBlend) return 1;
    double lever = 1;
    for (const Eigen::Vector3f& p : neutral.positions)
      lever = std::max(lever, (p.cast<double>() - step.axis_point).norm());
    return lever;
  }

  /// Blocks of one field: block -> its int16, only where one is not zero.
  struct Blocks {
    std::vector<int> blocks;  ///< ascending
    std::vector<std::int16_t> values;
  };

  Blocks quantise(const CascadeStep& step, double& unit) const {
    const int width = step.type == FieldType::kRotate || step.type == FieldType::kBlend ? 1 : 3;
    const std::vector<int>& points = fields.fields[step.field_idx].points;
    const std::vector<Eigen::Vector3f> values = values_of(step);
    float largest = 0;
    for (const Eigen::Vector3f& value : values)
      largest = std::max(largest, value.head(width).cwiseAbs().maxCoeff());
    unit = largest > 0 ? largest / kLargest : 1;
    std::vector<int> index(block_count(), -1);
    Blocks blocks;
    for (const int point : points) index[places[point] / kPoints] = 0;
    for (std::size_t block = 0; block < index.size(); ++block) {
      if (index[block] < 0) continue;
      index[block] = static_cast<int>(blocks.blocks.size());
      blocks.blocks.push_back(static_cast<int>(block));
    }
    blocks.values.assign(blocks.blocks.size() * kPoints * width, 0);
    for (std::size_t k = 0; k < points.size(); ++k) {
      const int place = places[points[k]];
      const std::size_t at =
          (static_cast<std::size_t>(index[place / kPoints]) * kPoints + place % kPoints) * width;
      for (int c = 0; c < width; ++c)
        blocks.values[at + c] = static_cast<std::int16_t>(std::lround(values[k][c] / unit));
    }
    return blocks;
  }

  /// Lays the blocks of all fields down in the order in which evaluate reads them.
  void lay_down() {
    const std::size_t steps = plan.steps.size(), operations = made.operations_.size();
    std::vector<Blocks> blocks(steps);
    made.step_steps_.assign(steps, 1.0);
    made.step_levers_.assign(steps, 0.0);
    for (std::size_t s = 0; s < steps; ++s) {
      const CascadeStep& step = plan.steps[s];
      made.step_parameters_.push_back(step.parameter_idx);
      made.step_gains_.push_back(step.gain);
      if (step.type == FieldType::kConstant) continue;
      blocks[s] = quantise(step, made.step_steps_[s]);
      made.step_levers_[s] = lever_of(step);
    }
    std::vector<std::size_t> next(steps, 0);
    for (std::size_t block = 0; block < block_count(); ++block) {
      for (std::size_t i = 0; i < operations; ++i) {
        made.entry_offsets_.push_back(static_cast<std::uint32_t>(made.entries_.size()));
        for (const int s : made.operations_[i].steps) {
          Blocks& source = blocks[s];
          if (next[s] >= source.blocks.size() || source.blocks[next[s]] != static_cast<int>(block)) continue;
          const std::size_t length = source.values.size() / source.blocks.size();
          made.entries_.push_back(
              {static_cast<std::uint32_t>(made.data_.size()), static_cast<std::uint32_t>(s)});
          const auto from = source.values.begin() + static_cast<std::ptrdiff_t>(next[s]++ * length);
          made.data_.insert(made.data_.end(), from, from + static_cast<std::ptrdiff_t>(length));
        }
      }
    }
    made.entry_offsets_.push_back(static_cast<std::uint32_t>(made.entries_.size()));
  }
};

CompiledCascade::CompiledCascade(const Deformation& deformation, const SampledFields& fields,
                                 const NeutralSurface& neutral) {
  const CascadePlan plan = make_cascade_plan(deformation, neutral.landmarks);
  CONTRACT(fields.point_count == neutral.positions.size() &&
           fields.fields.size() == deformation.fields.size());
  if (neutral.positions.empty()) throw InvalidInput("a surface without points cannot be deformed");
  parameter_count_ = plan.parameter_count;
  CascadeCompiler compiler{plan, fields, neutral, *this, {}, {}};
  compiler.order_points();
  compiler.assign_operations();
  compiler.lay_down();
}

}  // namespace phiz
