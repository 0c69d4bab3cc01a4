#include "orchestrator/parameter.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include "orchestrator/error.h"

namespace phiz {
namespace {

template <class Number>
std::optional<Number> parse_number(const std::string& text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::optional<bool> parse_flag(const std::string& text) {
  if (text == "true" || text == "yes" || text == "1") return true;
  if (text == "false" || text == "no" || text == "0") return false;
  return std::nullopt;
}

bool is_printable(const std::string& text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

std::string join(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : "|") + word;
  return text;
}

bool is_in_range(const Parameter& parameter, double value) {
  return std::isfinite(value) && value >= parameter.minimum && value <= parameter.maximum;
}

std::string describe_range(const Parameter& parameter) {
  const bool has_minimum = std::isfinite(parameter.minimum), has_maximum = std::isfinite(parameter.maximum);
  if (has_minimum && has_maximum) {
    return " from " + format_value(parameter.minimum) + " to " + format_value(parameter.maximum);
  }
  if (has_minimum) return " of at least " + format_value(parameter.minimum);
  if (has_maximum) return " of at most " + format_value(parameter.maximum);
  return {};
}

struct Format {
  std::string operator()(bool value) const { return value ? "true" : "false"; }
  std::string operator()(std::int64_t value) const { return std::to_string(value); }
  std::string operator()(double value) const {
    if (value == 0) return "0";
    std::array<char, 32> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
    return std::string(text.data(), end);
  }
  std::string operator()(const std::string& value) const { return value; }
};

}  // namespace

Parameter number(const char* name, double value, Range range, const char* unit, const char* doc) {
  return {name, value, unit, doc, "", range.minimum, range.maximum, {}, ""};
}

Parameter whole(const char* name, int value, Range range, const char* unit, const char* doc) {
  return {name, std::int64_t{value}, unit, doc, "", range.minimum, range.maximum, {}, ""};
}

Parameter choice(const char* name, const char* value, std::vector<std::string> choices, const char* doc) {
  return {name, std::string(value), "", doc, "", 0, 0, std::move(choices), ""};
}

std::string format_value(const ParameterValue& value) {
  return std::visit(Format{}, value);
}

std::string describe_type(const Parameter& parameter) {
  if (std::holds_alternative<bool>(parameter.default_value)) return "true|false";
  if (std::holds_alternative<std::int64_t>(parameter.default_value)) {
    return "whole number" + describe_range(parameter);
  }
  if (std::holds_alternative<double>(parameter.default_value)) return "number" + describe_range(parameter);
  return parameter.choices.empty() ? "text" : join(parameter.choices);
}

ParameterValue parse_value(const Parameter& parameter, const std::string& text, const std::string& label) {
  if (std::holds_alternative<bool>(parameter.default_value)) {
    if (const auto flag = parse_flag(text)) return *flag;
  } else if (std::holds_alternative<std::int64_t>(parameter.default_value)) {
    const auto number = parse_number<std::int64_t>(text);
    if (number && is_in_range(parameter, static_cast<double>(*number))) return *number;
  } else if (std::holds_alternative<double>(parameter.default_value)) {
    const auto number = parse_number<double>(text);
    if (number && is_in_range(parameter, *number)) return *number;
  } else if (parameter.choices.empty()
                 ? is_printable(text)
                 : std::count(parameter.choices.begin(), parameter.choices.end(), text) > 0) {
    return text;
  }
  throw UsageError(label + ": '" + text + "' is not " + describe_type(parameter));
}

ParameterValues resolve_parameters(std::span<const Parameter> parameters, const std::string& stage,
                                   const Settings& settings) {
  ParameterValues values;
  for (const Parameter& parameter : parameters) values[parameter.name] = parameter.default_value;
  const auto own = settings.find(stage);
  if (own == settings.end()) return values;
  for (const auto& [name, value] : own->second) {
    const auto found = values.find(name);
    if (found == values.end()) {
      throw UsageError(stage + " has no parameter '" + name + "'", "see phiz explain " + stage);
    }
    found->second = value;
  }
  return values;
}

}  // namespace phiz
