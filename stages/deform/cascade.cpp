#include <cmath>

#include "stages/deform/cascade_plan.h"
#include "stages/deform/deform.h"
#include "stages/geometry/error.h"

namespace phiz {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// What a step makes of a place. dq is empty where it is not asked for.
using State = CascadePoint;

struct Turn {
  Matrix3d matrix, slope;  ///< the rotation and its derivative in the angle
};

Turn turn_about(const Vector3d& axis, double angle) {
  Matrix3d cross;
  cross << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  const Matrix3d square = cross * cross;
  return {Matrix3d::Identity() + std::sin(angle) * cross + (1 - std::cos(angle)) * square,
          std::cos(angle) * cross + std::sin(angle) * square};
}

/// One place of the cascade, step by step.
class Walk {
 public:
  Walk(const CascadePlan& plan, std::span<const double> parameters, const SurfaceSample& place, bool has_dq)
      : plan_(plan),
        parameters_(parameters),
        place_(place),
        has_dq_(has_dq),
        states_(plan.steps.size()),
        sources_(plan.steps.size()) {}

  template <typename Sample>
  State run(const Sample& sample_of) {
    for (std::size_t s = 0; s < plan_.steps.size(); ++s) {
      const CascadeStep& step = plan_.steps[s];
      sources_[s] = static_cast<int>(s);
      if (step.is_neutral) {
        states_[s] = {place_.position, place_.du, place_.dv, {}};
        if (has_dq_) states_[s].dq.setZero(3, static_cast<Eigen::Index>(plan_.parameter_count));
        continue;
      }
      const FieldSample* sample = sample_of(step.field_idx);
      if (step.type == FieldType::kConstant) {
        states_[s] = sample == nullptr ? State{Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero(), {}}
                                       : State{sample->value, sample->du, sample->dv, {}};
        if (has_dq_) states_[s].dq.setZero(3, static_cast<Eigen::Index>(plan_.parameter_count));
        continue;
      }
      if (sample == nullptr) {
        sources_[s] = sources_[step.first];
        continue;
      }
      states_[s] = states_[sources_[step.first]];
      act(step, *sample, states_[s]);
    }
    return states_[sources_.back()];
  }

 private:
  void act(const CascadeStep& step, const FieldSample& sample, State& state) const {
    const double amount = amount_of(step, step.parameter_idx < 0 ? 0 : parameters_[step.parameter_idx]);
    switch (step.type) {
      case FieldType::kAdd:
        return add(step, sample, amount, state);
      case FieldType::kAddLocal:
        return add(step,
                   {place_.frame * sample.value, place_.frame_du * sample.value + place_.frame * sample.du,
                    place_.frame_dv * sample.value + place_.frame * sample.dv},
                   amount, state);
      case FieldType::kRotate:
        return rotate(step, sample, amount, state);
      default:
        return blend(step, sample, amount, state);
    }
  }

  void add(const CascadeStep& step, const FieldSample& sample, double amount, State& state) const {
    state.position += amount * sample.value;
    state.du += amount * sample.du;
    state.dv += amount * sample.dv;
    if (has_dq_ && step.parameter_idx >= 0) state.dq.col(step.parameter_idx) += step.gain * sample.value;
  }

  void rotate(const CascadeStep& step, const FieldSample& sample, double amount, State& state) const {
    const Turn turn = turn_about(step.axis_direction, amount * sample.value.x());
    const Vector3d arm = state.position - step.axis_point, way = turn.slope * arm;
    state.position = step.axis_point + turn.matrix * arm;
    state.du = turn.matrix * state.du + amount * sample.du.x() * way;
    state.dv = turn.matrix * state.dv + amount * sample.dv.x() * way;
    if (!has_dq_) return;
    state.dq = (turn.matrix * state.dq).eval();
    if (step.parameter_idx >= 0) state.dq.col(step.parameter_idx) += step.gain * sample.value.x() * way;
  }

  void blend(const CascadeStep& step, const FieldSample& sample, double amount, State& state) const {
    const State& other = states_[sources_[step.second]];
    const double share = amount * sample.value.x();
    const Vector3d way = other.position - state.position;
    state.du += share * (other.du - state.du) + amount * sample.du.x() * way;
    state.dv += share * (other.dv - state.dv) + amount * sample.dv.x() * way;
    state.position += share * way;
    if (!has_dq_) return;
    state.dq += share * (other.dq - state.dq);
    if (step.parameter_idx >= 0) state.dq.col(step.parameter_idx) += step.gain * sample.value.x() * way;
  }

  const CascadePlan& plan_;
  std::span<const double> parameters_;
  const SurfaceSample& place_;
  bool has_dq_;
  std::vector<State> states_;
  std::vector<int> sources_;  ///< the step whose state a step shares: its own, or that of its input
};

/// Samples of all fields of a plan at one place; null where a field is zero with its slopes.
struct Samples {
  std::vector<FieldSample> values;
  std::vector<bool> is_there;
  const FieldSample* operator()(int field_idx) const {
    return is_there[field_idx] ? &values[field_idx] : nullptr;
  }
};

Samples sample_all(const Deformation& deformation, const AnalyticFields& analytic,
                   const Eigen::Vector2d& uv) {
  Samples samples{std::vector<FieldSample>(deformation.fields.size()),
                  std::vector<bool>(deformation.fields.size(), false)};
  for (std::size_t f = 0; f < deformation.fields.size(); ++f) {
    const DeformationField& field = deformation.fields[f];
    const auto function = analytic.find(field.name);
    FieldSample& sample = samples.values[f];
    sample = function != analytic.end() ? function->second(uv)
                                        : sample_field(field, deformation.width, deformation.height, uv);
    samples.is_there[f] = !(sample.value.isZero(0) && sample.du.isZero(0) && sample.dv.isZero(0));
  }
  return samples;
}

}  // namespace

Cascade::Cascade(const Deformation& deformation, const std::map<std::string, Eigen::Vector3d>& landmarks,
                 AnalyticFields analytic)
    : plan_(std::make_unique<CascadePlan>(make_cascade_plan(deformation, landmarks))),
      deformation_(std::make_shared<Deformation>(deformation)),
      analytic_(std::move(analytic)) {}

Cascade::~Cascade() = default;

Eigen::Vector3d Cascade::evaluate(std::span<const double> parameters, const SurfaceSample& place) const {
  CONTRACT(parameters.size() == plan_->parameter_count);
  const Samples samples = sample_all(*deformation_, analytic_, place.uv);
  return Walk(*plan_, parameters, place, false).run(samples).position;
}

CascadePoint Cascade::differentiate(std::span<const double> parameters, const SurfaceSample& place) const {
  CONTRACT(parameters.size() == plan_->parameter_count);
  const Samples samples = sample_all(*deformation_, analytic_, place.uv);
  return Walk(*plan_, parameters, place, true).run(samples);
}

CascadePoint Cascade::differentiate(std::span<const double> parameters, const SampledFields& fields,
                                    const NeutralSurface& neutral, std::size_t point_idx) const {
  CONTRACT(parameters.size() == plan_->parameter_count && point_idx < fields.point_count);
  SurfaceSample place;
  place.position = neutral.positions[point_idx].cast<double>();
  place.frame = neutral.frames[point_idx].cast<double>();
  const int begin = fields.offsets[point_idx], end = fields.offsets[point_idx + 1];
  FieldSample sample;
  return Walk(*plan_, parameters, place, true).run([&](int field_idx) -> const FieldSample* {
    for (int k = begin; k < end; ++k) {
      if (fields.point_fields[k] != field_idx) continue;
      sample.value = fields.fields[field_idx].values[fields.point_entries[k]].cast<double>();
      return &sample;
    }
    return nullptr;
  });
}

}  // namespace phiz
