#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace phiz {

/// Where a long computation leaves the results of its steps, so that one that was interrupted need not repeat
/// them. Numbers come back bit for bit. Steps are named by the computation; what it works on is the keeper's
/// business.
class StepKeeper {
 public:
  virtual ~StepKeeper() = default;
  virtual std::optional<std::vector<double>> find(const std::string& step) = 0;
  virtual void keep(const std::string& step, std::span<const double> numbers) = 0;
};

}  // namespace phiz
