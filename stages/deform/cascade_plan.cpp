#include "stages/deform/cascade_plan.h"

#include "stages/geometry/error.h"

namespace phiz {
namespace {

using Landmarks = std::map<std::string, Eigen::Vector3d>;

const Eigen::Vector3d& get(const Landmarks& landmarks, const std::string& name, const std::string& field) {
  const auto found = landmarks.find(name);
  if (found == landmarks.end())
    throw InvalidInput("field '" + field + "' needs landmark '" + name + "', which the head does not have");
  return found->second;
}

Eigen::Vector3d place_of(const LandmarkPoint& point, const Landmarks& landmarks, const std::string& field) {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  for (const auto& [name, weight] : point) place += weight * get(landmarks, name, field);
  return place;
}

}  // namespace

CascadePlan make_cascade_plan(const Deformation& deformation, const Landmarks& landmarks) {
  check_deformation(deformation);
  std::map<std::string, int> parameters, steps;
  for (const DeformationParameter& parameter : deformation.parameters)
    parameters.emplace(parameter.name, static_cast<int>(parameters.size()));
  CascadePlan plan;
  plan.parameter_count = parameters.size();
  for (const int field_idx : compute_cascade_order(deformation)) {
    const DeformationField& field = deformation.fields[field_idx];
    CascadeStep step;
    step.type = field.type;
    step.field_idx = field_idx;
    if (!field.inputs.empty()) step.first = steps.at(field.inputs[0]);
    if (field.inputs.size() > 1) step.second = steps.at(field.inputs[1]);
    if (!field.parameter.empty()) step.parameter_idx = parameters.at(field.parameter);
    step.gain = field.gain;
    if (!field.scale.from.empty()) {
      const double length =
          (get(landmarks, field.scale.to, field.name) - get(landmarks, field.scale.from, field.name)).norm();
      step.gain *= length / field.scale.reference_mm;
    }
    step.is_neutral = field.type == FieldType::kConstant && field.image.empty();
    if (field.type == FieldType::kRotate) {
      step.axis_point = place_of(field.axis.from, landmarks, field.name);
      const Eigen::Vector3d along = place_of(field.axis.to, landmarks, field.name) - step.axis_point;
      if (!(along.norm() > 1e-3)) throw InvalidInput("field '" + field.name + "': its axis has no length");
      step.axis_direction = along.normalized();
    }
    steps[field.name] = static_cast<int>(plan.steps.size());
    plan.steps.push_back(step);
  }
  return plan;
}

}  // namespace phiz
