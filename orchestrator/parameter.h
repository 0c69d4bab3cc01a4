#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace phiz {

using ParameterValue = std::variant<bool, std::int64_t, double, std::string>;

/// One knob of a stage: what `phiz explain` prints, `--set stage.name=value` sets and the key contains.
struct Parameter {
  std::string name;              ///< [a-z0-9_]+, with its unit: voxel_mm
  ParameterValue default_value;  ///< its type is the parameter's type
  std::string unit;              ///< "mm"; empty if none
  std::string doc;               ///< one sentence
  std::string source;            ///< where the default comes from: a section of a paper, a measurement
  double minimum = -std::numeric_limits<double>::infinity();  ///< of numbers; inclusive
  double maximum = std::numeric_limits<double>::infinity();
  std::vector<std::string> choices;  ///< of texts; empty: any printable ASCII
  std::string option;                ///< "--units" if `phiz fit` has an option of its own for it

  Parameter from(std::string where) && { return source = std::move(where), std::move(*this); }
  Parameter with_option(std::string name_of_option) && {
    return option = std::move(name_of_option), std::move(*this);
  }
};

struct Range {
  double minimum, maximum;  ///< inclusive
};
// Shorthands for tables; a number without a unit has "".
Parameter number(const char* name, double value, Range range, const char* unit, const char* doc);
Parameter whole(const char* name, int value, Range range, const char* unit, const char* doc);
Parameter choice(const char* name, const char* value, std::vector<std::string> choices, const char* doc);

/// All parameters of one stage, by name.
using ParameterValues = std::map<std::string, ParameterValue>;

/// Parameters set by the user: stage -> name -> value. What is absent has its default.
using Settings = std::map<std::string, ParameterValues>;

/// Canonical text: the shortest decimal that reads back to the same double, true/false, no -0.
std::string format_value(const ParameterValue& value);

/// "number", "whole number", "yes or no", "text" or the choices.
std::string describe_type(const Parameter& parameter);

/// Checks type, range and choices. Throws UsageError that names `label` ("ingest.voxel_mm").
ParameterValue parse_value(const Parameter& parameter, const std::string& text, const std::string& label);

/// Defaults overridden by settings. Throws UsageError for a name the stage does not have.
ParameterValues resolve_parameters(std::span<const Parameter> parameters, const std::string& stage,
                                   const Settings& settings);

}  // namespace phiz
