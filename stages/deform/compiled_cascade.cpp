#include "stages/deform/compiled_cascade.h"

#include <cmath>

#include "stages/deform/cascade_kernels.h"
#include "stages/geometry/error.h"

namespace phiz {

std::vector<float> CompiledCascade::make_amounts(std::span<const float> parameters) const {
  CONTRACT(parameters.size() == parameter_count_);
  std::vector<float> amounts(step_gains_.size());
  for (std::size_t s = 0; s < amounts.size(); ++s) {
    const double parameter = step_parameters_[s] < 0 ? 1.0 : parameters[step_parameters_[s]];
    amounts[s] = static_cast<float>(step_gains_[s] * parameter * step_steps_[s]);
  }
  return amounts;
}

void CompiledCascade::evaluate(std::span<const float> parameters, std::span<Eigen::Vector3f> positions,
                               VectorPath path) const {
  CONTRACT(positions.size() == order_.size());
  const std::vector<float> amounts = make_amounts(parameters);
  std::vector<const float*> constants;
  for (const std::vector<float>& constant : constants_) constants.push_back(constant.data());
  CascadeRun run;
  run.operations = operations_;
  run.entry_offsets = entry_offsets_.data();
  run.entries = entries_.data();
  run.data = data_.data();
  run.neutral = neutral_.data();
  run.constants = constants.data();
  run.amounts = amounts.data();
  run.order = order_.data();
  run.point_count = order_.size();
  run.result_slot = result_slot_;
  run.positions = positions.data();
  const bool is_wide =
      path == VectorPath::kAvx2 || (path == VectorPath::kBest && has_vector_path(VectorPath::kAvx2));
  if (is_wide)
    run_cascade_avx2(run);
  else
    run_cascade_plain(run);
}

std::size_t CompiledCascade::bytes_touched(std::span<const float> parameters) const {
  const std::vector<float> amounts = make_amounts(parameters);
  std::size_t bytes = order_.size() * sizeof(int) + order_.size() * sizeof(Eigen::Vector3f) +
                      neutral_.size() * sizeof(float) + entry_offsets_.size() * sizeof(std::uint32_t) +
                      entries_.size() * sizeof(Entry);
  for (const std::vector<float>& constant : constants_) bytes += constant.size() * sizeof(float);
  const std::size_t blocks = (order_.size() + kBlockPoints - 1) / kBlockPoints;
  for (std::size_t block = 0; block < blocks; ++block) {
    for (std::size_t i = 0; i < operations_.size(); ++i) {
      const std::size_t length = (operations_[i].kind == Kind::kLinear ? 3 : 1) * kBlockPoints;
      const std::size_t at = block * operations_.size() + i;
      for (std::uint32_t k = entry_offsets_[at]; k < entry_offsets_[at + 1]; ++k)
        bytes += amounts[entries_[k].step] == 0 ? 0 : length * sizeof(std::int16_t);
    }
  }
  return bytes;
}

double CompiledCascade::error_bound_mm(std::span<const float> parameters) const {
  const std::vector<float> amounts = make_amounts(parameters);
  double bound = 2e-4;  // float's rounding of positions up to some 200 mm, a few times
  for (std::size_t s = 0; s < amounts.size(); ++s)
    bound += std::abs(static_cast<double>(amounts[s])) * 0.5 * std::sqrt(3.0) * step_levers_[s];
  return bound;
}

}  // namespace phiz
