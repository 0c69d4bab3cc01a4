#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "formats/deformation.h"

namespace phiz {

/// One field as it acts on one subject.
struct CascadeStep {
  FieldType type = FieldType::kConstant;
  int field_idx = 0;            ///< in the deformation
  int first = -1, second = -1;  ///< steps it works on
  int parameter_idx = -1;       ///< -1: the amount is `gain`
  double gain = 1;              ///< with the subject's scale
  bool is_neutral = false;      ///< a constant without image
  Eigen::Vector3d axis_point = Eigen::Vector3d::Zero(), axis_direction = Eigen::Vector3d::UnitX();
};

struct CascadePlan {
  std::vector<CascadeStep> steps;  ///< each after those it works on; the last is the result
  std::size_t parameter_count = 0;
};

/// Throws FormatError (check_deformation) and InvalidInput: a landmark the subject lacks, an axis without
/// length.
CascadePlan make_cascade_plan(const Deformation& deformation,
                              const std::map<std::string, Eigen::Vector3d>& landmarks);

inline double amount_of(const CascadeStep& step, double parameter) {
  return step.parameter_idx < 0 ? step.gain : step.gain * parameter;
}

}  // namespace phiz
